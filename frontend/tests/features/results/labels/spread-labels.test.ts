import { describe, expect, it } from "vitest";

import { spreadLabels } from "@/features/results/labels/spread-labels";

describe("labels", () => {
  it("stand at the ends of lines that are far apart", () => {
    expect(spreadLabels([20, 80], [10, 10], 100)).toEqual([15, 75]);
  });

  it("keep the order of lines that end close to each other, and touch", () => {
    expect(spreadLabels([52, 50, 48], [10, 10, 10], 100)).toEqual([55, 45, 35]);
  });

  it("stay within the chart", () => {
    expect(spreadLabels([0, 1, 99], [10, 10, 10], 100)).toEqual([0, 10, 90]);
  });

  it("begin at the top where there is no room for all", () => {
    expect(spreadLabels([5, 5, 5], [10, 10, 10], 20)).toEqual([0, 10, 20]);
  });
});
