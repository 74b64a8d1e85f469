import { describe, expect, it } from "vitest";

import { furtherRows, winnerOf } from "@/features/results/games/winner";

import { game, recording } from "../../../support/data";

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
      game({ start_number: 5, action_selection: "sampled" }),
    ];
    const shown = [{ start_number: 0, held_out: true, imitator: null, clone: null, winner: null }];
    const rows = furtherRows(games, shown);
    expect(rows.map((row) => row.start_number)).toEqual([3, 4]);
    expect(rows[1]).toMatchObject({ winner: "tie", clone: { policy: "clone" } });
  });
});
