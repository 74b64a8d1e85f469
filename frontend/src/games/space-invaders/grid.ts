import { allCells, type Cell, type ItemGridSize } from "@/lib/game/items";

export const GRID: ItemGridSize = { rows: 6, columns: 6 };

/** All aliens, top row first, from left to right. */
export const ALL_CELLS: readonly Cell[] = allCells(GRID);
