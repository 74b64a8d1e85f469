/** Pure functions that choose target cells, kept in order of choice. */
import { type Cell, cellKey, type ItemGridSize } from "@/lib/game/items";

/** Appends a cell, or removes it if it is chosen. */
export function toggleCell(chosen: readonly Cell[], cell: Cell): readonly Cell[] {
  const key = cellKey(cell);
  const without = chosen.filter((other) => cellKey(other) !== key);
  return without.length < chosen.length ? without : [...chosen, cell];
}

/** Appends the missing cells of a line; if none is missing, removes the line. */
export function toggleLine(chosen: readonly Cell[], line: readonly Cell[]): readonly Cell[] {
  const have = new Set(chosen.map(cellKey));
  const missing = line.filter((cell) => !have.has(cellKey(cell)));
  if (missing.length > 0) return [...chosen, ...missing];
  const gone = new Set(line.map(cellKey));
  return chosen.filter((cell) => !gone.has(cellKey(cell)));
}

/** The cells of a column from the bottom up, the order in which they can be hit. */
export function columnCells(column: number, { rows }: ItemGridSize): readonly Cell[] {
  return Array.from({ length: rows }, (_, row) => [row, column] as const);
}

/** The cells of a row from left to right. */
export function rowCells(row: number, { columns }: ItemGridSize): readonly Cell[] {
  return Array.from({ length: columns }, (_, column) => [row, column] as const);
}

/** The cell that a key leads to, within the grid; null if the key does not move. */
export function neighbour(
  [row, column]: Cell,
  key: string,
  { rows, columns }: ItemGridSize,
): Cell | null {
  const moves: Readonly<Record<string, Cell>> = {
    ArrowUp: [row + 1, column],
    ArrowDown: [row - 1, column],
    ArrowLeft: [row, column - 1],
    ArrowRight: [row, column + 1],
    Home: [row, 0],
    End: [row, columns - 1],
  };
  const to = moves[key];
  if (!to) return null;
  return [Math.min(Math.max(to[0], 0), rows - 1), Math.min(Math.max(to[1], 0), columns - 1)];
}
