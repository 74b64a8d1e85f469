import { describe, expect, it } from "vitest";

import { defaultsOf, errorsIn, type FormValues, readWhole, runOf } from "@/features/training/form";
import { valueRows } from "@/lib/recipe-values";
import { estimateInWords, standing } from "@/lib/runs";

const RECIPE = {
  name: "fast",
  summary: "Fast.",
  default_steps: 300_000,
  learning_rate: 0.0003,
  values: {},
  steps_per_s: 500,
  steps_per_s_measured: true,
  overhead_s: 120,
};

function values(change: Partial<FormValues> = {}): FormValues {
  return { ...defaultsOf(RECIPE), ...change };
}

describe("the training form", () => {
  it("begins with a recipe that can be sent as it is", () => {
    expect(errorsIn(values())).toEqual({});
    expect(runOf(values(), 3, false)).toEqual({
      behaviour_id: 3,
      recipe: "fast",
      steps: 300_000,
      learning_rate: 0.0003,
      training_seed: 0,
      go_on_anyway: false,
      example: false,
    });
  });

  it.each([
    ["300,000", 300_000],
    ["300 000", 300_000],
    ["1_000", 1000],
    ["", NaN],
    ["1e5", NaN],
    ["-5", NaN],
    ["12.5", NaN],
  ])("reads %j as %d", (text, number) => expect(readWhole(text)).toBe(number));

  it.each([
    [{ steps: "0" }, "steps"],
    [{ steps: "many" }, "steps"],
    [{ steps: "100000001" }, "steps"],
    [{ learningRate: "0" }, "learningRate"],
    [{ learningRate: "2" }, "learningRate"],
    [{ learningRate: " " }, "learningRate"],
    [{ trainingSeed: "-1" }, "trainingSeed"],
    [{ trainingSeed: "2147483648" }, "trainingSeed"],
  ])("refuses %o and says what would do", (change, field) => {
    const errors = errorsIn(values(change));
    expect(Object.keys(errors)).toEqual([field]);
    expect(runOf(values(change), 1, false)).toBeNull();
  });

  it("states how long it takes", () => {
    expect(estimateInWords(RECIPE, 300_000)).toBe("about 12 min");
  });
});

describe("a run's standing", () => {
  const going = {
    status: "running",
    stage: "imitator",
    progress: 0.427,
    remaining_s: 540,
  } as const;

  it("names stage, share and time", () => {
    expect(standing(going)).toBe("Imitator, 42 %, about 9 min left");
    expect(standing({ ...going, remaining_s: null })).toBe("Imitator, 42 %");
    expect(standing({ ...going, status: "stopped" })).toBe("Stopped by the check");
  });
});

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
