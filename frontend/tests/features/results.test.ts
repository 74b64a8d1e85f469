import { describe, expect, it } from "vitest";

import { game, recording } from "../support/data";

import { pathOf } from "@/features/behaviours/path";
import { curveGroups } from "@/features/results/curves";
import { marksOf, returnOf, worthOf } from "@/features/results/extrapolation";
import { summaryRows } from "@/features/results/summary-rows";
import { furtherRows, winnerOf } from "@/features/results/winner";

function played(targets: number | null, strays: number | null) {
  return game({ recording: recording({ targets, strays }) });
}

describe("the winner of a start", () => {
  it.each([
    [3, 5, 2, 0, "imitator"],
    [2, 0, 3, 9, "clone"],
    [3, 1, 3, 2, "imitator"],
    [3, 2, 3, 1, "clone"],
    [0, 1, 0, 1, "tie"],
  ])("with %d targets, %d strays against %d, %d is: %s", (t1, s1, t2, s2, winner) => {
    expect(winnerOf(played(t1, s1), played(t2, s2))).toBe(winner);
  });

  it("is nobody without a target or a second game", () => {
    expect(winnerOf(played(null, null), played(null, null))).toBeNull();
    expect(winnerOf(played(3, 1), undefined)).toBeNull();
  });
});

describe("the further starts", () => {
  it("are the greedy games that aren't shown yet, in order", () => {
    const games = [
      game({ start_number: 4, policy: "clone" }),
      game({ start_number: 3 }),
      game({ start_number: 4 }),
      game({ start_number: 0 }),
      game({ start_number: 5, choice: "sampled" }),
    ];
    const shown = [{ start_number: 0, held_out: true, imitator: null, clone: null, winner: null }];
    const rows = furtherRows(games, shown);
    expect(rows.map((row) => row.start_number)).toEqual([3, 4]);
    expect(rows[1]).toMatchObject({ winner: "tie", clone: { policy: "clone" } });
  });
});

describe("the summary", () => {
  const interval = { mean: 4, low: 3, high: 5, n: 23 };
  const summary = {
    targets: interval,
    strays: interval,
    order_errors: interval,
    steps: interval,
    hit_share: { mean: 0.25, low: 0.1, high: 0.4, n: 23 },
    predicted_return: { mean: -2, low: -5, high: 1, n: 23 },
  };

  it("compares what there is, order errors where the order matters", () => {
    const names = summaryRows(summary, null, 6, true).map((row) => row.name);
    expect(names).toContain("Targets hit, of 6");
    expect(names).toContain("Hits out of order");
    expect(summaryRows(summary, null, 6, false).map((row) => row.name)).not.toContain(
      "Hits out of order",
    );
  });

  it("leaves out targets where there are none", () => {
    const bare = { ...summary, targets: null, strays: null, order_errors: null };
    expect(summaryRows(bare, bare, null, false).map((row) => row.name)).toEqual([
      "Game length, steps of 300",
      "Games ended by a bomb",
      "Predicted return",
    ]);
  });

  it("holds both intervals in one axis that includes zero", () => {
    const row = summaryRows(summary, summary, 6, false).at(-1);
    expect(row).toMatchObject({ low: -5, high: 1 });
    expect(row?.write(-2)).toBe("−2.00");
  });
});

describe("returns and worth", () => {
  const game = (worth: number, value: number, id: number) => ({
    true_quantity: worth,
    predicted_return: value,
    recording_id: id,
  });
  const judged = [
    {
      player: "person" as const,
      demonstrated: true,
      tau: 1,
      games: [game(-4, -1, 1), game(6, 9, 2)],
    },
    { player: "clone" as const, demonstrated: false, tau: null, games: [game(6, 12, 3)] },
  ];

  it("are marks beside each other where they share a worth, hollow where unseen", () => {
    const marks = marksOf(judged);
    expect(marks.map(({ x, y, thing, hollow }) => [x, y, thing, hollow])).toEqual([
      [-4.125, -1, "person", false],
      [5.875, 9, "person", false],
      [6.125, 12, "clone", true],
    ]);
    expect(new Set(marks.map(({ key }) => key)).size).toBe(3);
  });

  it("have bounds over all who played", () => {
    expect(worthOf(judged)).toEqual({ low: -4, high: 6 });
    expect(returnOf(judged)).toEqual({ low: -1, high: 12 });
    expect(worthOf([])).toBeNull();
  });
});

describe("the curves", () => {
  it("are those for which there are points, each stage in its colour", () => {
    const groups = curveGroups({
      imitator: { hits: [[1, 2]], strays: [[1, 0]], entropy: [] },
      clone: { loss: [[1, 2]] },
    });
    expect(groups.map((group) => group.stage)).toEqual(["imitator", "clone"]);
    expect(groups[0]?.charts.map((chart) => chart.title)).toEqual(["Aliens hit per game"]);
    expect(groups[0]?.charts[0]?.curves).toMatchObject([
      { name: "targets", colour: "var(--imitator)", dashed: false },
      { name: "strays", colour: "var(--imitator)", dashed: true },
    ]);
    expect(groups[1]?.charts[0]?.curves[0]?.colour).toBe("var(--clone)");
  });
});

describe("the path", () => {
  const none = { n_recordings: 0, n_ranked: 0, n_perfect: 0, target: null };
  const nextOf = (...args: Parameters<typeof pathOf>) =>
    pathOf(...args)
      .filter((step) => step.next)
      .map((step) => step.id);

  it("leads from playing to looking, one step at a time", () => {
    const played = { ...none, n_recordings: 3 };
    const ranked = { ...played, n_ranked: 3, n_perfect: 1 };
    const running = { status: "running" as const, progress: 0.426, headline: null };
    expect(nextOf(none, [])).toEqual(["play"]);
    expect(nextOf(played, [])).toEqual(["rank"]);
    expect(nextOf({ ...played, n_ranked: 3 }, [])).toEqual(["rank"]);
    expect(nextOf(ranked, [])).toEqual(["train"]);
    expect(nextOf(ranked, [running])).toEqual(["look"]);
    expect(nextOf(ranked, [{ ...running, status: "done" }])).toEqual([]);
    expect(pathOf(ranked, [running])[2]?.caption).toBe("42 % done");
  });
});
