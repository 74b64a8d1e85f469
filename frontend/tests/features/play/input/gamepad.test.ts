import { describe, expect, it } from "vitest";

import { newlyPressed, NO_PAD, type Pad, PAD, Pads } from "@/features/play/input/gamepad";
import { FIRE, LEFT, RIGHT } from "@/features/play/input/keys";

const STANDARD = { id: "Pad", index: 0, connected: true, mapping: "standard" };

function pad(pressed: readonly number[], x = 0): Pad {
  const buttons = Array.from({ length: 17 }, (_, number) => ({
    pressed: pressed.includes(number),
  }));
  return { ...STANDARD, axes: [x, 0], buttons };
}

/** The state of gamepads whose sticks were seen at rest. */
function padState(pads: readonly (Pad | null)[]) {
  const reader = new Pads();
  reader.read(pads.map((one) => one && { ...one, axes: [0, 0] }));
  return reader.read(pads);
}

describe("a gamepad", () => {
  it.each([
    ["nothing", pad([]), 0],
    ["a stick near its rest", pad([], 0.3), 0],
    ["the stick to the left", pad([], -0.9), LEFT],
    ["the stick to the right", pad([], 0.5), RIGHT],
    ["the cross to the left and a button", pad([14, PAD.bottom]), LEFT | FIRE],
    ["the cross to the right", pad([15]), RIGHT],
    ["any of the four buttons", pad([PAD.top]), FIRE],
  ])("holds what %s means", (_, held, bits) => {
    expect(padState([null, held]).bits).toBe(bits);
  });

  it("rewinds with the buttons at its back", () => {
    expect(padState([pad([5])]).rewind).toBe(true);
    expect(padState([pad([PAD.start])]).rewind).toBe(false);
  });

  it("adds up with others, and has as few buttons and axes as it likes", () => {
    expect(padState([pad([14]), { ...pad([PAD.left]), index: 1 }]).bits).toBe(LEFT | FIRE);
    expect(padState([{ ...STANDARD, axes: [], buttons: [] }])).toEqual(NO_PAD);
  });

  it("steers once its stick was seen at rest, and anew after it was unplugged", () => {
    const reader = new Pads();
    const left = pad([], -1);
    expect(reader.read([left]).bits).toBe(0);
    expect(reader.read([pad([], 0.1)]).bits).toBe(0);
    expect(reader.read([left]).bits).toBe(LEFT);
    expect(reader.read([{ ...left, id: "Another pad" }]).bits).toBe(0);
    expect(reader.read([pad([])]).bits).toBe(0);
    expect(reader.read([left]).bits).toBe(LEFT);
    expect(reader.read([{ ...left, connected: false }]).bits).toBe(0);
    expect(reader.read([left]).bits).toBe(0);
    expect(reader.read([null]).bits).toBe(0);
  });

  it("that rests is not taken for another that does not", () => {
    const reader = new Pads();
    const stuck = { ...pad([], -1), index: 1 };
    expect(reader.read([pad([]), stuck]).bits).toBe(0);
    expect(reader.read([pad([], 1), stuck]).bits).toBe(RIGHT);
  });

  it("in another layout is left alone: its axes may rest at an end", () => {
    const other = { ...pad([PAD.bottom, 5, 14], -1), mapping: "" };
    expect(padState([other])).toEqual(NO_PAD);
  });

  it("says which buttons went down", () => {
    const before = padState([pad([0, 5])]);
    expect(newlyPressed(before, padState([pad([0, 9])]))).toEqual([9]);
    expect(newlyPressed(before, NO_PAD)).toEqual([]);
  });
});
