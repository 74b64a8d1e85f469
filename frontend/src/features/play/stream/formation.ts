/** Where the aliens of a game stand on its screen, in its pixels. Pure. */
import { type Cell, cellKey, ROWS } from "@/lib/game/aliens";

/** Left edge of the first column and top edge of the top row, of the full grid of 6 by 6. */
export interface Formation {
  readonly left: number;
  readonly top: number;
}

/** How the server says that the grid is laid out (docs/protocol.md). */
export interface AlienGeometry {
  readonly width: number;
  readonly height: number;
  /** From one column's left edge to the next one's. */
  readonly column_px: number;
  /** From one row's top edge to the next one's. */
  readonly row_px: number;
}

export interface Box {
  readonly left: number;
  readonly top: number;
  readonly width: number;
  readonly height: number;
}

/** The box of an alien. */
export function alienBox([row, column]: Cell, at: Formation, aliens: AlienGeometry): Box {
  return {
    left: at.left + column * aliens.column_px,
    top: at.top + (ROWS - 1 - row) * aliens.row_px,
    width: aliens.width,
    height: aliens.height,
  };
}

interface TimedHit {
  readonly row: number;
  readonly column: number;
  readonly frame: number;
}

/** How many of the hits, in order of time, had happened by a frame. */
export function hitsUntil(hits: readonly TimedHit[], frame: number): number {
  let n = 0;
  while (n < hits.length && (hits[n]?.frame ?? 0) <= frame) n += 1;
  return n;
}

/** The cells that are still there after the first so many hits. */
export function cellsLeft(
  cells: readonly Cell[],
  hits: readonly TimedHit[],
  nHits: number,
): readonly Cell[] {
  const shot = new Set(hits.slice(0, nHits).map(({ row, column }) => cellKey([row, column])));
  return cells.filter((cell) => !shot.has(cellKey(cell)));
}
