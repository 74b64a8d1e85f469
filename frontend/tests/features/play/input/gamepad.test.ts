import { describe, expect, it } from "vitest";

import { newlyPressed, NO_PAD, type Pad, PAD, padState } from "@/features/play/input/gamepad";
import { FIRE, LEFT, RIGHT } from "@/features/play/input/keys";

function pad(pressed: readonly number[], x = 0): Pad {
  const buttons = Array.from({ length: 17 }, (_, number) => ({
    pressed: pressed.includes(number),
  }));
  return { axes: [x, 0], buttons };
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
    expect(padState([pad([14]), pad([PAD.left])]).bits).toBe(LEFT | FIRE);
    expect(padState([{ axes: [], buttons: [] }])).toEqual(NO_PAD);
  });

  it("says which buttons went down", () => {
    const before = padState([pad([0, 5])]);
    expect(newlyPressed(before, padState([pad([0, 9])]))).toEqual([9]);
    expect(newlyPressed(before, NO_PAD)).toEqual([]);
  });
});
