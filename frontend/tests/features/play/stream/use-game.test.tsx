import { describe, expect, it } from "vitest";

import { lastChanceOf } from "@/features/play/stream/use-game";

describe("playing on after the end", () => {
  it("begins two seconds before it, or at the start", () => {
    expect(lastChanceOf({ frame: 558 })).toBe(438);
    expect(lastChanceOf({ frame: 90 })).toBe(0);
  });
});
