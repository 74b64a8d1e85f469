import { describe, expect, it } from "vitest";

import { resumeFrameOf } from "@/features/play/stream/use-game";

describe("playing on after the end", () => {
  it("begins two seconds before it, or at the start", () => {
    expect(resumeFrameOf({ frame: 558 })).toBe(438);
    expect(resumeFrameOf({ frame: 90 })).toBe(0);
  });
});
