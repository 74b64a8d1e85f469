import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { allCells, type Cell, cellKey, cellName, gridState, strayWords } from "@/lib/game/items";

const SIZE = { rows: 6, columns: 18 };
const ALL_CELLS = allCells(SIZE);

const cells = fc.uniqueArray(fc.constantFrom(...ALL_CELLS), { selector: cellKey });

describe("the grid", () => {
  it("sorts each item into exactly one state", () => {
    fc.assert(
      fc.property(cells, cells, (hits, target) => {
        const state = gridState(SIZE, hits, target);
        const sorted = Object.values(state).flat() as Cell[];
        expect(sorted.map(cellKey).sort()).toEqual(ALL_CELLS.map(cellKey).sort());
      }),
    );
  });

  it("keeps hits in order of time", () => {
    const target: Cell[] = [
      [0, 1],
      [0, 3],
    ];
    const hits: Cell[] = [
      [0, 3],
      [2, 2],
      [0, 1],
    ];
    expect(gridState(SIZE, hits, target).hit).toEqual([
      [0, 3],
      [0, 1],
    ]);
  });

  it("is put into words", () => {
    expect([0, 1, 2].map(strayWords)).toEqual(["no strays", "1 stray", "2 strays"]);
    expect(cellName([0, 4])).toBe("row 1, column 5");
  });
});
