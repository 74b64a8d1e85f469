/** The 6x6 grid of aliens: its cells, its sprites and its state. */
import { plural, t } from "@lingui/core/macro";

export const ROWS = 6;
export const COLUMNS = 6;

/** [row from the bottom, column from the left], from 0. */
export type Cell = readonly [row: number, column: number];

/** One sprite per row, bottom row first; 8x8 pixels, drawn for this page. */
// prettier-ignore
const SPRITES: readonly (readonly string[])[] = [
  [
    "..#..#..",
    "...##...",
    ".######.",
    "##.##.##",
    "########",
    ".#.##.#.",
    "#......#",
    ".#....#.",
  ],
  [
    "..####..",
    ".######.",
    "#..##..#",
    "########",
    ".##..##.",
    "..#..#..",
    ".#.##.#.",
    "#......#",
  ],
  [
    "...##...",
    "..####..",
    ".######.",
    "##.##.##",
    "########",
    "..#..#..",
    ".#.##.#.",
    "#.#..#.#",
  ],
  [
    "#......#",
    ".#.##.#.",
    ".######.",
    "##.##.##",
    "########",
    ".######.",
    ".#....#.",
    "##....##",
  ],
  [
    "##....##",
    ".##..##.",
    "..####..",
    ".##..##.",
    "########",
    "#.####.#",
    "#.#..#.#",
    "...##...",
  ],
  [
    "#..##..#",
    "#..##..#",
    "##.##.##",
    ".######.",
    ".#.##.#.",
    ".######.",
    "..#..#..",
    ".##..##.",
  ],
];

/** Side of a sprite in pixels. */
export const SPRITE_SIZE = 8;
/** Distance between the same edges of adjacent sprites, in pixels. */
export const CELL_SIZE = 10;
/** Side of the grid in pixels. */
export const GRID_SIZE = CELL_SIZE * (COLUMNS - 1) + SPRITE_SIZE;

/** Left edge of a column, in pixels. */
export function columnX(column: number): number {
  return column * CELL_SIZE;
}

/** Top edge of a row, in pixels; row 0 is the bottom row. */
export function rowY(row: number): number {
  return (ROWS - 1 - row) * CELL_SIZE;
}

/**
 * Returns the sprite of a row at (x, y) as an SVG path, one rectangle per run of pixels.
 *
 * @throws {RangeError} There is no such row.
 */
export function spritePath(row: number, x: number, y: number): string {
  const sprite = SPRITES[row];
  if (!sprite) throw new RangeError(`Expected a row from 0 to ${ROWS - 1}, got ${row}.`);
  let path = "";
  sprite.forEach((line, dy) => {
    for (const run of line.matchAll(/#+/g)) {
      const length = run[0].length;
      path += `M${x + run.index} ${y + dy}h${length}v1h${-length}z`;
    }
  });
  return path;
}

/** Returns the sprites of cells, in their places, as one SVG path. */
export function gridPath(cells: readonly Cell[]): string {
  return cells.map(([row, column]) => spritePath(row, columnX(column), rowY(row))).join("");
}

/** All cells, top row first, from left to right. */
export const ALL_CELLS: readonly Cell[] = Array.from(
  { length: ROWS * COLUMNS },
  (_, index) => [ROWS - 1 - Math.floor(index / COLUMNS), index % COLUMNS] as const,
);

/** Key of a cell for sets and maps. */
export function cellKey([row, column]: Cell): string {
  return `${row},${column}`;
}

/** Names a cell for people, who count from 1: "row 1, column 5". */
export function cellName([row, column]: Cell): string {
  return t`row ${row + 1}, column ${column + 1}`;
}

interface GridState {
  /** Remaining aliens outside the target; all that remain if there is no target. */
  readonly standing: readonly Cell[];
  /** Remaining target aliens. */
  readonly missing: readonly Cell[];
  /** Target aliens hit, in order of time. */
  readonly hit: readonly Cell[];
  /** Strays, in order of time. */
  readonly stray: readonly Cell[];
  /** Aliens hit where there is no target, in order of time. */
  readonly gone: readonly Cell[];
}

/** Sorts the cells of the grid by their state. */
export function gridState(
  hits: readonly Cell[],
  target: readonly Cell[] | null | undefined,
): GridState {
  const targets = new Set((target ?? []).map(cellKey));
  const shot = new Set(hits.map(cellKey));
  const left = ALL_CELLS.filter((cell) => !shot.has(cellKey(cell)));
  return {
    standing: left.filter((cell) => !targets.has(cellKey(cell))),
    missing: left.filter((cell) => targets.has(cellKey(cell))),
    hit: target ? hits.filter((cell) => targets.has(cellKey(cell))) : [],
    stray: target ? hits.filter((cell) => !targets.has(cellKey(cell))) : [],
    gone: target ? [] : hits,
  };
}

/** Describes the state of the grid in a sentence. */
export function describeGrid(
  hits: readonly Cell[],
  target: readonly Cell[] | null | undefined,
): string {
  const { hit, stray, gone } = gridState(hits, target);
  if (!target)
    return gone.length === 0
      ? t`No alien hit`
      : plural(gone.length, { one: "# alien hit", other: "# aliens hit" });
  const strays =
    stray.length === 0 ? t`no strays` : plural(stray.length, { one: "# stray", other: "# strays" });
  return t`${hit.length} of ${target.length} target aliens hit, ${strays}`;
}
