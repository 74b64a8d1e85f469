import { describe, expect, it } from "vitest";

import { endTicks, wholeTicks } from "@/features/results/reward/ticks";

describe("whole ticks", () => {
  it.each([
    [0, 6, 12, [0, 1, 2, 3, 4, 5, 6]],
    [-13, 6, 12, [-12, -10, -8, -6, -4, -2, 0, 2, 4, 6]],
    [-13, 6, 5, [-10, -5, 0, 5]],
    [3, 3, 5, [3]],
    [0, 1234, 6, [0, 500, 1000]],
    [-36, 36, 3, [-20, 0, 20]],
  ])("from %d to %d, at most %d", (low, high, most, ticks) => {
    expect(wholeTicks(low, high, most).map((tick) => tick + 0)).toEqual(ticks);
  });
});

describe("end ticks", () => {
  it("are both ends and the middle", () => {
    expect(endTicks(-2, 4)).toEqual([-2, 1, 4]);
    expect(endTicks(3, 3)).toEqual([3]);
  });
});
