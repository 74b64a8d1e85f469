import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { columnCells, neighbour, toggleCell, toggleLine } from "@/features/behaviours/targets";
import { ALL_CELLS, cellKey } from "@/lib/game/aliens";

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
        const line = columnCells(column);
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
        const to = neighbour(from, key);
        expect(to && ALL_CELLS.some((cell) => cellKey(cell) === cellKey(to))).toBe(true);
      }),
    );
    expect(neighbour([2, 2], "ArrowUp")).toEqual([3, 2]);
    expect(neighbour([2, 2], "a")).toBeNull();
  });
});
