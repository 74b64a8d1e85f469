import { describe, expect, it } from "vitest";

import { valueRows } from "@/lib/recipe-values";

describe("a recipe's values", () => {
  it("are listed by section, its own first", () => {
    const rows = valueRows({
      reward: { learning_rate: 0.00005, aligned: true, weight_decay: null },
      summary: "left out",
      default_steps: 300_000,
      evaluation: { start_numbers: [0, 1, 2], further: [3, 4, 5, 6, 7, 8] },
    });
    expect(rows).toEqual([
      { section: "", name: "default steps", value: "300,000" },
      { section: "reward", name: "learning rate", value: "5e−5" },
      { section: "reward", name: "aligned", value: "yes" },
      { section: "reward", name: "weight decay", value: "none" },
      { section: "evaluation", name: "start numbers", value: "0, 1, 2" },
      { section: "evaluation", name: "further", value: "3, 4, 5, 6 … 8" },
    ]);
  });
});
