import { describe, expect, it } from "vitest";

import { comparedGroups, meanWithBand } from "@/features/results/compare/compared-curves";
import { differenceRows, resultRows } from "@/features/results/compare/compared-rows";
import { comparedIds, comparePath, seedGroups } from "@/features/results/compare/compared-runs";

import { headline, run } from "../../../support/data";

const INTERVAL = { mean: 4, low: 3, high: 5, n: 23 };
const SUMMARY = {
  targets: INTERVAL,
  strays: null,
  order_errors: null,
  steps: INTERVAL,
  death_rate: { mean: 0.1, low: 0, high: 0.3, n: 23 },
  predicted_return: null,
};
const HEADLINE = headline({ imitator: SUMMARY });

describe("the address of a comparison", () => {
  it("names each run once, and at most ten", () => {
    expect(comparePath(["a", "b"])).toBe("/runs/compare?run=a&run=b");
    const many = Array.from({ length: 12 }, (_, index) => ["run", String(index)]);
    expect(comparedIds(new URLSearchParams([["run", "0"], ...many]))).toEqual(
      Array.from({ length: 10 }, (_, index) => String(index)),
    );
  });
});

describe("runs as lines", () => {
  it("are one line where only the training seed differs", () => {
    const runs = [
      run({ id: "a", training_seed: 0 }),
      run({ id: "b", steps: 1 }),
      run({ id: "c", training_seed: 1, name: "Again" }),
      run({ id: "d", recipe_values: { policy: { gamma: 0.9 } } }),
    ];
    const groups = seedGroups(runs);
    expect(groups.map((group) => group.runs.map(({ id }) => id))).toEqual([
      ["a", "c"],
      ["b"],
      ["d"],
    ]);
    expect(new Set(groups.map(({ colour }) => colour)).size).toBe(3);
  });

  it("are told apart by colour and dashes, all ten of them", () => {
    const runs = Array.from({ length: 10 }, (_, steps) => run({ id: String(steps), steps }));
    const looks = seedGroups(runs).map(({ colour, dashed }) => `${colour} ${dashed}`);
    expect(new Set(looks).size).toBe(10);
  });
});

describe("the rows of a comparison", () => {
  it("have each run's results, without what no run has", () => {
    const runs = [run({ headline: HEADLINE }), run({ id: "b" })];
    expect(resultRows(runs, "imitator", 6).map(({ name, cells }) => [name, cells])).toEqual([
      ["Targets hit, of 6", [INTERVAL, null]],
      ["Death rate", [SUMMARY.death_rate, null]],
    ]);
    expect(resultRows(runs, "clone", 6)).toEqual([]);
  });

  it("have how much each run does of what was understood, where there is a statement", () => {
    const understood = { imitator: INTERVAL, clone: null, best: INTERVAL, read: null };
    const runs = [run({ headline: headline({ understood }) }), run({ id: "b" })];
    expect(resultRows(runs, "imitator", null).map(({ name, cells }) => [name, cells])).toEqual([
      ["Worth by what Tril understood (100%: a full game)", [INTERVAL, null]],
    ]);
  });

  it("have the settings that differ, and no others", () => {
    const one = run({ recipe_values: { policy: { gamma: 0.9, n_envs: 8 } } });
    const other = run({
      steps: 500_000,
      recipe_values: { policy: { gamma: 0.99, n_envs: 8 }, cloning: { epochs: 2 } },
    });
    expect(differenceRows([one, other])).toEqual([
      { name: "steps", cells: ["20,000", "500,000"] },
      { name: "policy: gamma", cells: ["0.9", "0.99"] },
      { name: "cloning: epochs", cells: ["none", "2"] },
    ]);
    expect(differenceRows([one, { ...one, id: "b" }])).toEqual([]);
  });
});

describe("the curves of a comparison", () => {
  it("have a mean between the lowest and the highest where all curves are", () => {
    const found = meanWithBand([
      [
        [0, 0],
        [10, 10],
        [20, 20],
      ],
      [
        [5, 9],
        [15, 19],
        [30, 4],
      ],
    ]);
    expect(found.points).toEqual([
      [5, 7],
      [10, 12],
      [15, 17],
      [20, 17],
    ]);
    expect(found.band.low[1]).toEqual([10, 10]);
    expect(found.band.high[1]).toEqual([10, 14]);
  });

  it("are one chart for each curve, with a line for each run that has it", () => {
    const look = { colour: "red", dashed: false };
    const hits = { imitator: { hits: [[1, 2] as const], strays: [[1, 1] as const] } };
    const groups = comparedGroups([
      { ...look, runs: [{ name: "a", series: hits }] },
      { ...look, runs: [{ name: "b", series: { imitator: { hits: [[1, 3] as const] } } }] },
      {
        ...look,
        runs: [
          { name: "c", series: {} },
          { name: "d", series: hits },
          { name: "e", series: hits },
        ],
      },
    ]);
    expect(
      groups.map(({ stage, charts }) => [
        stage,
        charts.map(({ title, curves }) => [title, curves.map(({ name }) => name)]),
      ]),
    ).toEqual([
      [
        "imitator",
        [
          ["Hits per game: targets", ["a", "b", "d and 1 more"]],
          ["Hits per game: strays", ["a", "d and 1 more"]],
        ],
      ],
    ]);
    expect(groups[0]?.charts[0]?.curves[2]?.band?.low).toEqual([[1, 2]]);
  });
});
