import { describe, expect, it } from "vitest";

import { continuing, describeEstimate, runName, statusLine, withSearch } from "@/lib/runs";

import { STAGES } from "../support/data";

describe("a run's standing", () => {
  const going = {
    status: "running",
    stage: "imitator",
    stages: STAGES,
    progress: 0.427,
    remaining_s: 540,
    queue_position: null,
  } as const;

  it("names stage, share and time", () => {
    expect(statusLine(going)).toBe("Imitator, 42%, about 9\u00a0min left");
    expect(statusLine({ ...going, remaining_s: null })).toBe("Imitator, 42%");
    expect(statusLine({ ...going, status: "stopped" })).toBe("Stopped by the check");
  });
});

describe("a waiting run's standing", () => {
  const waiting = {
    status: "queued",
    stage: "",
    stages: STAGES,
    progress: 0,
    remaining_s: null,
  } as const;

  it.each([
    [1, "Waiting, next in the queue"],
    [3, "Waiting, number 3 in the queue"],
  ])("at place %i is %j", (queue_position, line) => {
    expect(statusLine({ ...waiting, queue_position })).toBe(line);
  });
});

describe("a run's name", () => {
  it("is a person's, or else the beginning of its id", () => {
    expect(runName({ id: "3f2a9c00", name: "Wide network" })).toBe("Wide network");
    expect(runName({ id: "3f2a9c00", name: "" })).toBe("Run 3f2a9c");
  });
});

describe("a run's estimate", () => {
  it("adds the overhead to the time of the steps", () => {
    expect(describeEstimate({ steps_per_s: 500, overhead_s: 120 }, 300_000)).toBe(
      "about 12\u00a0min",
    );
  });
});

describe("the run to continue", () => {
  const lead = (search: string) => withSearch("/train", continuing(new URLSearchParams(search)));

  it("is all that is led on with", () => {
    expect(lead("compare&continue=a1&steps=20&tour")).toBe("/train?continue=a1&steps=20");
  });

  it("needs no number of steps", () => {
    expect(lead("continue=a1")).toBe("/train?continue=a1");
  });

  it("takes the steps with it where it is dropped", () => {
    expect(lead("steps=20")).toBe("/train");
  });
});
