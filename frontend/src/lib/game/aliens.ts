/** The six kinds of alien, drawn for this page, and the shapes made of them. */

export const ROWS = 6;
export const COLUMNS = 6;

/** [row from the bottom, column from the left], from 0. */
export type Cell = readonly [row: number, column: number];

/** One sprite per row of the game, bottom row first; 8 by 8 pixels. */
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

/** Pixels per sprite and side. */
export const SPRITE_SIZE = 8;
/** Pixels from one sprite's left (or top) edge to the next one's. */
export const CELL_SIZE = 10;
/** Pixels of the whole grid and side. */
export const GRID_SIZE = CELL_SIZE * (COLUMNS - 1) + SPRITE_SIZE;

/** Left edge of a column in the grid's pixels. */
export function columnX(column: number): number {
  return column * CELL_SIZE;
}

/** Top edge of a row in the grid's pixels; row 0 is the bottom one. */
export function rowY(row: number): number {
  return (ROWS - 1 - row) * CELL_SIZE;
}

/** An SVG path of unit squares, joined along each line, for the sprite of a row at (x, y). */
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

/** One SVG path with the sprites of all cells at their places in the grid. */
export function gridPath(cells: readonly Cell[]): string {
  return cells.map(([row, column]) => spritePath(row, columnX(column), rowY(row))).join("");
}

/** The cells of the grid, top row first, from left to right. */
export const ALL_CELLS: readonly Cell[] = Array.from(
  { length: ROWS * COLUMNS },
  (_, index) => [ROWS - 1 - Math.floor(index / COLUMNS), index % COLUMNS] as const,
);

/** A key by which sets and maps can hold a cell. */
export function cellKey([row, column]: Cell): string {
  return `${row},${column}`;
}

/** "row 1, column 5": people count from 1, from the bottom and from the left. */
export function cellName([row, column]: Cell): string {
  return `row ${row + 1}, column ${column + 1}`;
}

export interface GridState {
  /** Aliens still there, outside the target (or all, without a target). */
  readonly standing: readonly Cell[];
  /** Target aliens still there. */
  readonly missing: readonly Cell[];
  /** Target aliens shot, in order of time. */
  readonly hit: readonly Cell[];
  /** Aliens shot outside the target, in order of time. */
  readonly stray: readonly Cell[];
  /** Aliens shot where there is no target to judge them by, in order of time. */
  readonly gone: readonly Cell[];
}

/** Sorts the grid's cells by what became of them. */
export function gridState(
  hits: readonly Cell[],
  target: readonly Cell[] | null | undefined,
): GridState {
  const wanted = new Set((target ?? []).map(cellKey));
  const shot = new Set(hits.map(cellKey));
  const left = ALL_CELLS.filter((cell) => !shot.has(cellKey(cell)));
  return {
    standing: left.filter((cell) => !wanted.has(cellKey(cell))),
    missing: left.filter((cell) => wanted.has(cellKey(cell))),
    hit: target ? hits.filter((cell) => wanted.has(cellKey(cell))) : [],
    stray: target ? hits.filter((cell) => !wanted.has(cellKey(cell))) : [],
    gone: target ? [] : hits,
  };
}

/** What a grid shows, in words. */
export function describeGrid(
  hits: readonly Cell[],
  target: readonly Cell[] | null | undefined,
): string {
  const { hit, stray, gone } = gridState(hits, target);
  if (!target) return gone.length === 0 ? "No alien hit" : `${countOf(gone.length, "alien")} hit`;
  const strays = stray.length === 0 ? "no strays" : countOf(stray.length, "stray");
  return `${hit.length} of ${target.length} target aliens hit, ${strays}`;
}

function countOf(n: number, noun: string): string {
  return n === 1 ? `1 ${noun}` : `${n} ${noun}s`;
}
