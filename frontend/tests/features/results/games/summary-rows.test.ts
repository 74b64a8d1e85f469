import { describe, expect, it } from "vitest";

import { summaryRows } from "@/features/results/games/summary-rows";

describe("the summary", () => {
  const interval = { mean: 4, low: 3, high: 5, n: 23 };
  const summary = {
    targets: interval,
    strays: interval,
    order_errors: interval,
    steps: interval,
    death_rate: { mean: 0.25, low: 0.1, high: 0.4, n: 23 },
    predicted_return: { mean: -2, low: -5, high: 1, n: 23 },
  };

  it("compares what there is, order errors where the order matters", () => {
    const names = summaryRows(summary, null, 6, true, 300).map((row) => row.name);
    expect(names).toContain("Targets hit, of 6");
    expect(names).toContain("Hits out of order");
    expect(summaryRows(summary, null, 6, false, 300).map((row) => row.name)).not.toContain(
      "Hits out of order",
    );
  });

  it("leaves out targets where there are none", () => {
    const bare = { ...summary, targets: null, strays: null, order_errors: null };
    expect(summaryRows(bare, bare, null, false, 500).map((row) => row.name)).toEqual([
      "Game length, of 500 steps",
      "Death rate",
      "Predicted return",
    ]);
  });

  it("holds both intervals in one axis that includes zero", () => {
    const row = summaryRows(summary, summary, 6, false, 300).at(-1);
    expect(row).toMatchObject({ low: -5, high: 1 });
    expect(row?.write(-2)).toBe("−2.00");
  });
});
