/** The countable things of a game as cells of a grid: where they are drawn, and their state. */
import { plural, t } from "@lingui/core/macro";

/** [row from the bottom, column from the left], from 0. */
export type Cell = readonly [row: number, column: number];

/** The size of a grid of items. */
export interface ItemGridSize {
  readonly rows: number;
  readonly columns: number;
}

/** Side of an item's picture in pixels. */
export const ITEM_SIZE = 8;
/** Distance between the same edges of adjacent items, in pixels. */
export const CELL_SIZE = 10;

/** Length of so many cells in pixels. */
export function gridLength(cells: number): number {
  return CELL_SIZE * (cells - 1) + ITEM_SIZE;
}

/** Left edge of a column, in pixels. */
export function columnX(column: number): number {
  return column * CELL_SIZE;
}

/** Top edge of a row, in pixels; row 0 is the bottom row. */
export function rowY(row: number, { rows }: ItemGridSize): number {
  return (rows - 1 - row) * CELL_SIZE;
}

/** Draws the item of a row with its left upper corner at (x, y), as an SVG path. */
export type ItemPath = (row: number, x: number, y: number) => string;

/** The picture of an item that has none of its own. */
export const plainItem: ItemPath = (_row, x, y) => `M${x} ${y + 1}h${ITEM_SIZE}v6h${-ITEM_SIZE}z`;

/** Returns the pictures of cells, in their places, as one SVG path. */
export function gridPath(cells: readonly Cell[], size: ItemGridSize, path: ItemPath): string {
  return cells.map(([row, column]) => path(row, columnX(column), rowY(row, size))).join("");
}

/** All cells, top row first, from left to right. */
export function allCells({ rows, columns }: ItemGridSize): readonly Cell[] {
  return Array.from(
    { length: rows * columns },
    (_, index) => [rows - 1 - Math.floor(index / columns), index % columns] as const,
  );
}

/** Key of a cell for sets and maps. */
export function cellKey([row, column]: Cell): string {
  return `${row},${column}`;
}

/** Names a cell for people, who count from 1: "row 1, column 5". */
export function cellName([row, column]: Cell): string {
  return t`row ${row + 1}, column ${column + 1}`;
}

/** Returns the cells taken, in order of time. */
export function takenCells(recording: {
  readonly hits: readonly { readonly row: number; readonly column: number }[];
}): readonly Cell[] {
  return recording.hits.map(({ row, column }) => [row, column] as const);
}

interface GridState {
  /** Remaining items outside the target. */
  readonly standing: readonly Cell[];
  /** Remaining targets. */
  readonly missing: readonly Cell[];
  /** Targets taken, in order of time. */
  readonly hit: readonly Cell[];
  /** Strays, in order of time. */
  readonly stray: readonly Cell[];
}

/** Sorts the cells of a grid by their state. */
export function gridState(
  size: ItemGridSize,
  taken: readonly Cell[],
  target: readonly Cell[],
): GridState {
  const targets = new Set(target.map(cellKey));
  const gone = new Set(taken.map(cellKey));
  const left = allCells(size).filter((cell) => !gone.has(cellKey(cell)));
  return {
    standing: left.filter((cell) => !targets.has(cellKey(cell))),
    missing: left.filter((cell) => targets.has(cellKey(cell))),
    hit: taken.filter((cell) => targets.has(cellKey(cell))),
    stray: taken.filter((cell) => !targets.has(cellKey(cell))),
  };
}

/** Counts strays: "no strays", "1 stray". */
export function strayWords(count: number): string {
  return count === 0 ? t`no strays` : plural(count, { one: "# stray", other: "# strays" });
}
