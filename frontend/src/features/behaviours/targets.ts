/** Choosing target cells: pure functions of the cells chosen so far, in the order chosen. */
import { type Cell, cellKey, COLUMNS, ROWS } from "@/lib/game/aliens";

/** Adds a cell at the end, or takes it out. */
export function toggleCell(chosen: readonly Cell[], cell: Cell): readonly Cell[] {
  const key = cellKey(cell);
  const without = chosen.filter((other) => cellKey(other) !== key);
  return without.length < chosen.length ? without : [...chosen, cell];
}

/** Adds all missing cells of a line at the end; if none is missing, takes them all out. */
export function toggleLine(chosen: readonly Cell[], line: readonly Cell[]): readonly Cell[] {
  const have = new Set(chosen.map(cellKey));
  const missing = line.filter((cell) => !have.has(cellKey(cell)));
  if (missing.length > 0) return [...chosen, ...missing];
  const gone = new Set(line.map(cellKey));
  return chosen.filter((cell) => !gone.has(cellKey(cell)));
}

/** A column's cells from the bottom up, as they are shot. */
export function columnCells(column: number): readonly Cell[] {
  return Array.from({ length: ROWS }, (_, row) => [row, column] as const);
}

/** A row's cells from left to right. */
export function rowCells(row: number): readonly Cell[] {
  return Array.from({ length: COLUMNS }, (_, column) => [row, column] as const);
}

/** The cell an arrow key leads to; the grid's edges hold. */
export function neighbour([row, column]: Cell, key: string): Cell | null {
  const moves: Readonly<Record<string, Cell>> = {
    ArrowUp: [row + 1, column],
    ArrowDown: [row - 1, column],
    ArrowLeft: [row, column - 1],
    ArrowRight: [row, column + 1],
    Home: [row, 0],
    End: [row, COLUMNS - 1],
  };
  const to = moves[key];
  if (!to) return null;
  return [Math.min(Math.max(to[0], 0), ROWS - 1), Math.min(Math.max(to[1], 0), COLUMNS - 1)];
}
