import fc from "fast-check";
import { describe, expect, it } from "vitest";

import {
  ALL_CELLS,
  type Cell,
  cellKey,
  cellName,
  describeGrid,
  gridState,
  spritePath,
} from "@/lib/game/aliens";

const cells = fc.uniqueArray(fc.constantFrom(...ALL_CELLS), { selector: cellKey });
const COLUMN_1 = ALL_CELLS.filter(([, column]) => column === 0);

describe("the grid", () => {
  it("sorts each alien into exactly one state", () => {
    fc.assert(
      fc.property(cells, fc.option(cells), (hits, target) => {
        const state = gridState(hits, target);
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
    expect(gridState(hits, target).hit).toEqual([
      [0, 3],
      [0, 1],
    ]);
  });

  it("is put into words", () => {
    expect(describeGrid([[0, 0]], COLUMN_1)).toBe("1 of 6 target aliens hit, no strays");
    expect(describeGrid([[1, 3]], COLUMN_1)).toBe("0 of 6 target aliens hit, 1 stray");
    expect(describeGrid([], null)).toBe("No alien hit");
    expect(cellName([0, 4])).toBe("row 1, column 5");
  });

  it("has a different sprite for each row, within its 8 by 8 pixels", () => {
    const paths = [0, 1, 2, 3, 4, 5].map((row) => spritePath(row, 0, 0));
    expect(new Set(paths).size).toBe(6);
    for (const path of paths) {
      for (const [, x, y, length] of path.matchAll(/M(\d+) (\d+)h(\d+)/g)) {
        expect(Number(x) + Number(length)).toBeLessThanOrEqual(8);
        expect(Number(y)).toBeLessThan(8);
      }
    }
    expect(() => spritePath(6, 0, 0)).toThrow(RangeError);
  });
});
