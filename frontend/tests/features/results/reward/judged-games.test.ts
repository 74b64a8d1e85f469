import { describe, expect, it } from "vitest";

import { marksOf, predictedOf, worthOf } from "@/features/results/reward/judged-games";

describe("returns and worth", () => {
  const game = (worth: number, value: number, id: number) => ({
    true_quantity: worth,
    predicted: value,
    recording_id: id,
  });
  const judged = [
    {
      player: "person" as const,
      demonstrated: true,
      measure: "final_level" as const,
      tau: 1,
      games: [game(-4, -1, 1), game(6, 9, 2)],
    },
    {
      player: "clone" as const,
      demonstrated: false,
      measure: "final_level" as const,
      tau: null,
      games: [game(6, 12, 3)],
    },
  ];

  it("are marks beside each other where they share a worth, hollow where unseen", () => {
    const marks = marksOf(judged);
    expect(marks.map(({ x, y, actor, hollow }) => [x, y, actor, hollow])).toEqual([
      [-4.125, -1, "person", false],
      [5.875, 9, "person", false],
      [6.125, 12, "clone", true],
    ]);
    expect(new Set(marks.map(({ key }) => key)).size).toBe(3);
  });

  it("have bounds over all who played", () => {
    expect(worthOf(judged)).toEqual({ low: -4, high: 6 });
    expect(predictedOf(judged)).toEqual({ low: -1, high: 12 });
    expect(worthOf([])).toBeNull();
  });
});
