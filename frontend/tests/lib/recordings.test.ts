import { describe, expect, it } from "vitest";

import { recordingName } from "@/lib/recordings";

import { recording } from "../support/data";

describe("the name of a recording", () => {
  it("is its number in its behaviour, whatever the database calls it", () => {
    expect(recordingName(recording({ id: 163, number: 1 }))).toBe("Recording 1");
  });

  it("has its origin where it is borrowed, since numbers are of a behaviour or a run", () => {
    const borrowed = { id: 7, number: 2, behaviour_name: "Column 2", borrowed: true };
    expect(recordingName(recording(borrowed))).toBe("Recording 2 of Column 2");
    expect(recordingName(recording({ ...borrowed, run_id: "3f2a9c41-0000" }))).toBe(
      "Recording 2 of Run 3f2a9c",
    );
  });

  it("has no number before the game has ended, or while nothing is known of it", () => {
    expect(recordingName(recording({ number: null }))).toBe("New recording");
    expect(recordingName(undefined)).toBe("Recording");
  });
});
