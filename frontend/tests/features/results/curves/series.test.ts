import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { align, mergeSeries, type Points } from "@/features/results/curves/series";

const points = fc
  .uniqueArray(fc.tuple(fc.nat(1000), fc.double({ noNaN: true })), { selector: ([step]) => step })
  .map((all) => all.sort(([a], [b]) => a - b) as Points);

describe("curves", () => {
  it("grow by later points", () => {
    const have = { imitator: { hits: [[1, 0.5]] as Points } };
    const more = {
      imitator: { hits: [[2, 0.75]] as Points },
      reward: { loss: [[1, 3]] as Points },
    };
    expect(mergeSeries(have, more)).toEqual({
      imitator: {
        hits: [
          [1, 0.5],
          [2, 0.75],
        ],
      },
      reward: { loss: [[1, 3]] },
    });
  });

  it("drop the points that a resumed worker repeats", () => {
    const have = {
      imitator: {
        hits: [
          [1, 1],
          [2, 2],
          [3, 3],
        ] as Points,
      },
    };
    const more = { imitator: { hits: [[2, 9]] as Points } };
    expect(mergeSeries(have, more).imitator?.hits).toEqual([
      [1, 1],
      [2, 9],
    ]);
  });

  it("have increasing steps, whatever arrives", () => {
    fc.assert(
      fc.property(points, points, (have, more) => {
        const merged = mergeSeries({ a: { b: have } }, { a: { b: more } }).a?.b ?? [];
        const steps = merged.map(([step]) => step);
        expect(steps).toEqual([...new Set(steps)].sort((a, b) => a - b));
      }),
    );
  });

  it("share one axis, with gaps where one has no point", () => {
    expect(
      align([
        [
          [1, 10],
          [3, 30],
        ],
        [[2, 20]],
      ]),
    ).toEqual([
      [1, 2, 3],
      [10, null, 30],
      [null, 20, null],
    ]);
  });
});
