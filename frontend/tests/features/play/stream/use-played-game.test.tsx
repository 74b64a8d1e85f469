import { describe, expect, it } from "vitest";

import { resumeFrameOf } from "@/features/play/stream/use-played-game";

describe("playing on after the end", () => {
  it("begins two seconds before it, or at the start", () => {
    expect(resumeFrameOf({ frame: 558 }, 60)).toBe(438);
    expect(resumeFrameOf({ frame: 90 }, 60)).toBe(0);
    expect(resumeFrameOf({ frame: 90 }, 15)).toBe(60);
  });
});
