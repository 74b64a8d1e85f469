import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { chartData, type ChartData, decimate } from "@/features/results/curves/chart-data";

/** A line over the steps 0, 1, 2, ... */
function line(values: readonly (number | null)[]): ChartData {
  return [values.map((_, index) => index), values];
}

function numbers(values: readonly (number | null)[] | undefined): number[] {
  return (values ?? []).filter((value) => value !== null);
}

describe("what a chart draws", () => {
  it("is all of a short curve, a single point too", () => {
    const data = line([3, 1, 2]);
    expect(decimate(data, null, 320)).toBe(data);
    expect(decimate(line([7]), null, 320)).toEqual([[0], [7]]);
    expect(decimate([[], []], null, 320)).toEqual([[], []]);
  });

  it("has few points of a long curve, but each peak", () => {
    const values = Array.from({ length: 100_000 }, (_, index) => Math.sin(index / 500));
    values[54_321] = 40;
    values[54_323] = -40;
    const [x, drawn] = decimate(line(values), null, 320);
    expect(x.length).toBeLessThanOrEqual(4 * 321);
    expect(x).toContain(54_321);
    expect(x).toContain(54_323);
    expect([x[0], x.at(-1)]).toEqual([0, 99_999]);
    expect(Math.max(...numbers(drawn))).toBe(40);
  });

  it("has the outline of every pixel column, of lines with gaps too", () => {
    const value = fc.option(fc.integer({ min: -50, max: 50 }), { nil: null });
    const data = fc
      .array(fc.tuple(value, value), { minLength: 1, maxLength: 400 })
      .map((rows): ChartData => [
        rows.map((_, index) => index * 3),
        rows.map(([one]) => one),
        rows.map(([, other]) => other),
      ]);
    fc.assert(
      fc.property(data, fc.integer({ min: 1, max: 30 }), (all, columns) => {
        const drawn = decimate(all, null, columns);
        const [x] = all;
        expect([...drawn[0]].sort((a, b) => a - b)).toEqual(drawn[0]);
        const width = (x.at(-1) ?? 0) / columns;
        for (const index of [1, 2]) {
          for (let column = 0; column < columns; column += 1) {
            const within = ([steps, ...lines]: ChartData) =>
              numbers(
                lines[index - 1]?.filter(
                  (_, at) => Math.floor((steps[at] ?? 0) / width) === column,
                ),
              );
            const [before, after] = [within(all), within(drawn)];
            expect(Math.min(...after)).toBe(Math.min(...before));
            expect(Math.max(...after)).toBe(Math.max(...before));
            expect([after[0], after.at(-1)]).toEqual([before[0], before.at(-1)]);
          }
        }
      }),
      { numRuns: 30 },
    );
  });

  it("is what a range shows, with a point beyond either end", () => {
    const data = line([0, 1, 2, 3, 4, 5, 6, 7]);
    expect(decimate(data, [2.5, 4.5], 320)[0]).toEqual([2, 3, 4, 5]);
    expect(decimate(data, [-5, 1], 320)[0]).toEqual([0, 1]);
  });

  it("gets finer with the range", () => {
    const data = line(Array.from({ length: 10_000 }, (_, index) => index % 7));
    const [x] = decimate(data, [5000, 5100], 320);
    expect(x).toEqual(Array.from({ length: 102 }, (_, index) => 4999 + index));
  });
});

describe("a curve with a band", () => {
  it("is followed by its highest and lowest values", () => {
    const data = chartData([
      { name: "mean", colour: "red", points: [[1, 2]], band: { low: [[1, 1]], high: [[1, 3]] } },
      { name: "other", colour: "blue", points: [[2, 5]] },
    ]);
    expect(data).toEqual([
      [1, 2],
      [2, null],
      [3, null],
      [1, null],
      [null, 5],
    ]);
  });
});
