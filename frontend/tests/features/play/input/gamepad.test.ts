import { describe, expect, it } from "vitest";

import { newlyPressed, NO_PAD, type Pad, PAD, Pads } from "@/features/play/input/gamepad";

import { BLACKJACK, MS_PACMAN, SPACE_INVADERS } from "../../../support/games";

const [LEFT, RIGHT, FIRE] = [1, 2, 4];
const { buttons: BUTTONS } = SPACE_INVADERS;

const STANDARD = { id: "Pad", index: 0, connected: true, mapping: "standard" };

function pad(pressed: readonly number[], x = 0): Pad {
  const buttons = Array.from({ length: 17 }, (_, number) => ({
    pressed: pressed.includes(number),
  }));
  return { ...STANDARD, axes: [x, 0], buttons };
}

/** The state of gamepads whose sticks were seen at rest. */
function padState(pads: readonly (Pad | null)[], buttons: readonly string[] = BUTTONS) {
  const reader = new Pads();
  reader.read(
    pads.map((one) => one && { ...one, axes: [0, 0] }),
    buttons,
  );
  return reader.read(pads, buttons);
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

  it("steers up and down, and across, in games that have it", () => {
    const across = { ...pad([]), axes: [0.8, -0.8] };
    expect(padState([across], MS_PACMAN.buttons).bits).toBe(2 | 4);
    expect(padState([pad([13, 14])], MS_PACMAN.buttons).bits).toBe(1 | 8);
    expect(padState([across], BUTTONS).bits).toBe(RIGHT);
  });

  it("presses the buttons of a game without directions with its face buttons", () => {
    expect(padState([pad([PAD.bottom])], BLACKJACK.buttons).bits).toBe(1);
    expect(padState([pad([PAD.right])], BLACKJACK.buttons).bits).toBe(2);
    expect(padState([pad([PAD.left, 14])], BLACKJACK.buttons).bits).toBe(0);
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
    expect(reader.read([left], BUTTONS).bits).toBe(0);
    expect(reader.read([pad([], 0.1)], BUTTONS).bits).toBe(0);
    expect(reader.read([left], BUTTONS).bits).toBe(LEFT);
    expect(reader.read([{ ...left, id: "Another pad" }], BUTTONS).bits).toBe(0);
    expect(reader.read([pad([])], BUTTONS).bits).toBe(0);
    expect(reader.read([left], BUTTONS).bits).toBe(LEFT);
    expect(reader.read([{ ...left, connected: false }], BUTTONS).bits).toBe(0);
    expect(reader.read([left], BUTTONS).bits).toBe(0);
    expect(reader.read([null], BUTTONS).bits).toBe(0);
  });

  it("that rests is not taken for another that does not", () => {
    const reader = new Pads();
    const stuck = { ...pad([], -1), index: 1 };
    expect(reader.read([pad([]), stuck], BUTTONS).bits).toBe(0);
    expect(reader.read([pad([], 1), stuck], BUTTONS).bits).toBe(RIGHT);
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
