import { describe, expect, it } from "vitest";

import { rangeOf, ticksOf } from "@/features/results/reward/measure";

describe("the axis of final levels", () => {
  it("goes from 0 to 1 where all games hit nothing", () => {
    expect(rangeOf("final_level", [-2.2e-4, 0, 1.4e-4])).toEqual([0, 1]);
  });

  it("reaches beyond for games that are worse than the beginning or better than the best", () => {
    expect(rangeOf("final_level", [-0.52, 0.3, 1.41])).toEqual([-0.5, 1.4]);
  });

  it("does not apply to predicted returns", () => {
    expect(rangeOf("predicted_return", [12, -3, 7])).toEqual([-3, 12]);
  });

  it("has ticks at 0 and 1, and at an end that is not beside them", () => {
    expect(ticksOf("final_level", 0, 1)).toEqual([0, 1]);
    expect(ticksOf("final_level", -2.2, 1.1)).toEqual([-2.2, 0, 1]);
    expect(ticksOf("predicted_return", 0, 10)).toEqual([0, 5, 10]);
  });
});
