import fc from "fast-check";
import { describe, expect, it } from "vitest";

import {
  columnCells,
  neighbour,
  toggleCell,
  toggleLine,
} from "@/features/behaviours/target/targets";
import { allCells, cellKey } from "@/lib/game/items";

const SIZE = { rows: 6, columns: 6 };
const ALL_CELLS = allCells(SIZE);

const cells = fc.uniqueArray(fc.constantFrom(...ALL_CELLS), { selector: cellKey });

describe("choosing targets", () => {
  it("twice changes nothing", () => {
    fc.assert(
      fc.property(cells, fc.constantFrom(...ALL_CELLS), (chosen, cell) => {
        const twice = toggleCell(toggleCell(chosen, cell), cell);
        expect(twice.map(cellKey).sort()).toEqual(chosen.map(cellKey).sort());
      }),
    );
  });

  it("goes by whole lines: first adds what is missing, then takes all out", () => {
    fc.assert(
      fc.property(cells, fc.nat(5), (chosen, column) => {
        const line = columnCells(column, SIZE);
        const once = toggleLine(chosen, line);
        const had = new Set(chosen.map(cellKey));
        const has = new Set(once.map(cellKey));
        const wasFull = line.every((cell) => had.has(cellKey(cell)));
        expect(line.every((cell) => has.has(cellKey(cell)) !== wasFull)).toBe(true);
        expect(has.size).toBe(once.length);
      }),
    );
  });

  it("by arrow keys stays on the grid", () => {
    const keys = ["ArrowUp", "ArrowDown", "ArrowLeft", "ArrowRight", "Home", "End"];
    fc.assert(
      fc.property(fc.constantFrom(...ALL_CELLS), fc.constantFrom(...keys), (from, key) => {
        const to = neighbour(from, key, SIZE);
        expect(to && ALL_CELLS.some((cell) => cellKey(cell) === cellKey(to))).toBe(true);
      }),
    );
    expect(neighbour([2, 2], "ArrowUp", SIZE)).toEqual([3, 2]);
    expect(neighbour([2, 2], "a", SIZE)).toBeNull();
  });
});
