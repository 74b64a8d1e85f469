import { describe, expect, it } from "vitest";

import { describeEstimate, statusLine } from "@/lib/runs";

import { STAGES } from "../support/data";

describe("a run's standing", () => {
  const going = {
    status: "running",
    stage: "imitator",
    stages: STAGES,
    progress: 0.427,
    remaining_s: 540,
  } as const;

  it("names stage, share and time", () => {
    expect(statusLine(going)).toBe("Imitator, 42%, about 9 min left");
    expect(statusLine({ ...going, remaining_s: null })).toBe("Imitator, 42%");
    expect(statusLine({ ...going, status: "stopped" })).toBe("Stopped by the check");
  });
});

describe("a run's estimate", () => {
  it("adds the overhead to the time of the steps", () => {
    expect(describeEstimate({ steps_per_s: 500, overhead_s: 120 }, 300_000)).toBe("about 12 min");
  });
});
