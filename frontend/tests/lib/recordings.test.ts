import { describe, expect, it } from "vitest";

import { describeCourse } from "@/lib/recordings";

describe("the course of a game", () => {
  it("counts a step that its end cut short, and takes the time from the frames", () => {
    const lost = { n_frames: 85, n_steps: 22, end: "hit", state: "kept" } as const;
    expect(describeCourse(lost)).toBe("22 steps, 1.4\u00a0s, hit by a bomb");
  });
});
