import { describe, expect, it } from "vitest";

import type { Run } from "@/api/types";
import {
  ALL_RUNS,
  filteredRuns,
  isNarrow,
  readRunsFilter,
  type RunsFilter,
  writeRunsFilter,
} from "@/features/results/list/runs-filter";

import { headline, run } from "../../../support/data";

const INTERVAL = { mean: 0, low: 0, high: 0, n: 5 };

function figures(targets: number, deaths: number): Run["headline"] {
  return headline({
    imitator: {
      targets: { ...INTERVAL, mean: targets },
      strays: INTERVAL,
      order_errors: null,
      steps: INTERVAL,
      death_rate: { ...INTERVAL, mean: deaths },
      predicted_return: null,
    },
  });
}

const RUNS = [
  run({
    id: "aaaaaaaa",
    name: "Wide network",
    notes: "Twice as wide.",
    status: "done",
    steps: 10,
    headline: figures(3, 0.1),
    created_at: "2026-01-01T12:00:00Z",
  }),
  run({
    id: "bbbbbbbb",
    recipe: "paper",
    status: "queued",
    queue_position: 1,
    steps: 30,
    created_at: "2026-01-03T12:00:00Z",
  }),
  run({
    id: "cccccccc",
    name: "baseline 10",
    status: "done",
    steps: 20,
    headline: figures(5, 0.4),
    created_at: "2026-01-02T12:00:00Z",
  }),
  run({
    id: "dddddddd",
    name: "Baseline 9",
    status: "failed",
    steps: 20,
    created_at: "2026-01-04T12:00:00Z",
  }),
];

function ids(change: Partial<RunsFilter>): string {
  return filteredRuns(RUNS, { ...ALL_RUNS, ...change })
    .map(({ id }) => id[0])
    .join("");
}

describe("the filter of runs", () => {
  it.each([
    [{ state: "active" }, "b"],
    [{ state: "done" }, "ca"],
    [{ state: "stopped" }, ""],
    [{ recipe: "paper" }, "b"],
    [{ q: "wide" }, "a"],
    [{ q: "TWICE network" }, "a"],
    [{ q: "run bbbb" }, "b"],
    [{ q: "paper" }, "b"],
    [{ q: "baseline", state: "done" }, "c"],
    [{ q: "  " }, "dbca"],
  ] as const)("%o finds %j", (change, found) => expect(ids(change)).toBe(found));

  it.each([
    ["newest", "dbca"],
    ["oldest", "acbd"],
    ["name", "dcba"],
    ["targets", "cadb"],
    ["deaths", "acdb"],
    ["steps", "bdca"],
  ] as const)("by %s the order is %s", (order, found) => expect(ids({ order })).toBe(found));

  it("is kept in the address, defaults left out", () => {
    const filter = { state: "done", recipe: "fast", q: "big net", order: "name" } as const;
    expect(readRunsFilter(writeRunsFilter(filter))).toEqual(filter);
    expect(String(writeRunsFilter(ALL_RUNS))).toBe("");
    expect(readRunsFilter(new URLSearchParams("state=odd&order=odd"))).toEqual(ALL_RUNS);
  });

  it("is narrow unless it only sorts", () => {
    expect(isNarrow({ ...ALL_RUNS, order: "steps" })).toBe(false);
    expect(isNarrow({ ...ALL_RUNS, q: "x" })).toBe(true);
  });
});
