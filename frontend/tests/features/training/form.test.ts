import { afterEach, describe, expect, it } from "vitest";

import { defaultsOf, errorsIn, type FormValues, readWhole, runOf } from "@/features/training/form";
import { i18n } from "@/lib/i18n";

const RECIPE = {
  name: "fast",
  summary: "Fast.",
  default_steps: 300_000,
  ordered_steps: 900_000,
  warm_up_steps: 12_000,
  learning_rate: 0.0003,
  values: {},
  steps_per_s: 500,
  steps_per_s_measured: true,
  overhead_s: 120,
  stages: [],
};

function values(change: Partial<FormValues> = {}): FormValues {
  return { ...defaultsOf(RECIPE, { ordered: false }), ...change };
}

afterEach(() => i18n.activate("en"));

describe("the training form", () => {
  it("proposes more steps for aliens in order", () => {
    expect(defaultsOf(RECIPE, { ordered: false }).steps).toBe("300,000");
    expect(defaultsOf(RECIPE, { ordered: true }).steps).toBe("900,000");
  });

  it("begins with a recipe that can be sent as it is", () => {
    expect(errorsIn(values())).toEqual({});
    expect(runOf(values(), 3, false, null, false)).toEqual({
      behaviour_id: 3,
      recipe: "fast",
      steps: 300_000,
      learning_rate: 0.0003,
      training_seed: 0,
      go_on_anyway: false,
      device: "any",
      example: false,
      parent_run_id: null,
      cancel_parent: false,
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
    expect(runOf(values(change), 1, false, null, false)).toBeNull();
  });

  it("shows and reads numbers as German writes them", () => {
    i18n.loadAndActivate({ locale: "de", messages: {} });
    expect(values()).toMatchObject({ steps: "300.000", learningRate: "0,0003" });
    expect(errorsIn(values())).toEqual({});
    expect(runOf(values(), 3, false, null, false)).toMatchObject({
      steps: 300_000,
      learning_rate: 0.0003,
    });
    expect(errorsIn(values({ learningRate: "0.0003" }))).toEqual({});
    expect(Object.keys(errorsIn(values({ steps: "1,5" })))).toEqual(["steps"]);
  });
});
