import { describe, expect, it } from "vitest";

import { pathOf } from "@/features/behaviours/path";

import { headline } from "../../support/data";

describe("the path", () => {
  const none = { n_recordings: 0, n_ranked: 0, n_perfect: 0, target: null };
  const nextOf = (...args: Parameters<typeof pathOf>) =>
    pathOf(...args)
      .filter((step) => step.next)
      .map((step) => step.id);

  it("leads from playing to looking, one step at a time", () => {
    const played = { ...none, n_recordings: 3 };
    const ranked = { ...played, n_ranked: 3, n_perfect: 1 };
    const running = { status: "running" as const, progress: 0.426, headline: null };
    expect(nextOf(none, [])).toEqual(["play"]);
    expect(nextOf(played, [])).toEqual(["rank"]);
    expect(nextOf({ ...played, n_ranked: 1 }, [])).toEqual(["rank"]);
    expect(nextOf({ ...played, n_ranked: 3 }, [])).toEqual(["train"]);
    expect(nextOf(ranked, [])).toEqual(["train"]);
    expect(nextOf({ ...ranked, n_recordings: 0 }, [])).toEqual(["train"]);
    expect(nextOf(ranked, [running])).toEqual([]);
    expect(nextOf(ranked, [{ ...running, status: "done" }])).toEqual([]);
  });

  it("calls training done once a run has finished, and says how far one is", () => {
    const ranked = { ...none, n_recordings: 3, n_ranked: 3, n_perfect: 1 };
    const train = (...runs: Parameters<typeof pathOf>[1]) => pathOf(ranked, runs)[2];
    const running = { status: "running" as const, progress: 0.346, headline: null };
    expect(train(running)).toMatchObject({ done: false, caption: "Training, 34%" });
    expect(train({ ...running, status: "queued" })?.caption).toBe("Waiting to train");
    expect(train({ ...running, status: "failed" })).toMatchObject({ done: false, next: true });
    const again = train(running, { ...running, status: "done" });
    expect(again).toMatchObject({ done: true, caption: "Training, 34%" });
  });

  it("ends with how much of what was understood the imitator plays", () => {
    const share = { mean: 0.876, low: 0.8, high: 0.9, n: 23 };
    const understood = { imitator: share, clone: null, best: share, read: null };
    const done = { status: "done" as const, progress: 1, headline: headline({ understood }) };
    expect(pathOf(none, [done])[3]?.caption).toBe("imitator: 88%");
  });
});
