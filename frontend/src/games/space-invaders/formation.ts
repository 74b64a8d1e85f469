/** The positions of the aliens on the game's screen, in its pixels. */
import type { Overlay, TakenAt } from "@/games/view";
import { type Cell, cellKey } from "@/lib/game/items";

import { GRID } from "./grid";

/** Left edge of the first column and top edge of the top row of the full 6x6 grid. */
export interface Formation {
  readonly left: number;
  readonly top: number;
}

/** The layout of the grid, as the server sends it (docs/protocol.md). */
export interface AlienGeometry {
  readonly width: number;
  readonly height: number;
  /** From one column's left edge to the next one's. */
  readonly column_px: number;
  /** From one row's top edge to the next one's. */
  readonly row_px: number;
}

interface Box {
  readonly left: number;
  readonly top: number;
  readonly width: number;
  readonly height: number;
}

/** Added to the formation's left edge, which can lie left of the screen, to make it unsigned. */
const LEFT_BIAS = 96;

/** Reads the position of the aliens from the marks of a frame. */
export function formationOf(marks: Uint8Array): Formation {
  return { left: (marks[0] ?? 0) - LEFT_BIAS, top: marks[1] ?? 0 };
}

/** Returns the layout of the grid, or null if the overlay is another one. */
export function alienGeometry(overlay: Overlay): AlienGeometry | null {
  if (overlay.painter !== "alien-formation") return null;
  const { width = 0, height = 0, column_px = 0, row_px = 0 } = overlay.geometry;
  return { width, height, column_px, row_px };
}

/** Returns the bounding box of an alien. */
export function alienBox([row, column]: Cell, at: Formation, aliens: AlienGeometry): Box {
  return {
    left: at.left + column * aliens.column_px,
    top: at.top + (GRID.rows - 1 - row) * aliens.row_px,
    width: aliens.width,
    height: aliens.height,
  };
}

/** Counts the hits up to a frame. */
export function hitsUntil(hits: readonly TakenAt[], frame: number): number {
  let n = 0;
  while (n < hits.length && (hits[n]?.frame ?? 0) <= frame) n += 1;
  return n;
}

/** Returns the cells that remain after the first `nHits` hits. */
export function cellsLeft(
  cells: readonly Cell[],
  hits: readonly TakenAt[],
  nHits: number,
): readonly Cell[] {
  const shot = new Set(hits.slice(0, nHits).map(({ row, column }) => cellKey([row, column])));
  return cells.filter((cell) => !shot.has(cellKey(cell)));
}
