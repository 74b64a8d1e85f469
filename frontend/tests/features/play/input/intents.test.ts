import { describe, expect, it } from "vitest";

import { PAD } from "@/features/play/input/gamepad";
import { GRACE_MS, padWishOf, speedBeside, steers, wishOf } from "@/features/play/input/intents";
import { DEFAULT_KEYS } from "@/features/play/input/keys";

const press = (code: string, repeat = false) => ({ code, repeat });

describe("keys after the end", () => {
  it.each([
    ["KeyK", "keep"],
    ["Enter", "keep"],
    ["KeyD", "discard"],
    ["KeyP", "perfect"],
    ["Space", "again"],
    ["KeyR", "again"],
    ["Backspace", "rewind"],
  ])("%s asks to %s", (code, wish) => {
    expect(wishOf(press(code), "ended", GRACE_MS)).toBe(wish);
  });

  it("mean nothing while they may still be meant for the game", () => {
    expect(wishOf(press("Space"), "ended", GRACE_MS - 1)).toBeNull();
    expect(wishOf(press("Space", true), "ended", 10 * GRACE_MS)).toBeNull();
  });
});

describe("keys in the game", () => {
  it("pause it and go on", () => {
    expect(wishOf(press("Escape"), "playing", Infinity)).toBe("pause");
    expect(wishOf(press("Enter"), "paused", Infinity)).toBe("go_on");
    expect(wishOf(press("Space"), "paused", Infinity)).toBe("go_on");
  });

  it("play a paused game frame by frame, also when held", () => {
    expect(wishOf(press("Period"), "playing", Infinity)).toBe("pause");
    expect(wishOf(press("Period", true), "playing", Infinity)).toBeNull();
    expect(wishOf(press("Period"), "paused", Infinity)).toBe("step");
    expect(wishOf(press("Period", true), "stepping", Infinity)).toBe("step");
    expect(wishOf(press("Enter"), "stepping", Infinity)).toBe("go_on");
    expect(wishOf(press("Space"), "stepping", Infinity)).toBeNull();
    expect(steers("stepping")).toBe(true);
  });

  it("run the game back, also out of a pause", () => {
    for (const phase of ["playing", "countdown", "paused", "stepping"] as const) {
      expect(wishOf(press("Backspace"), phase, Infinity)).toBe("rewind");
    }
    expect(wishOf(press("Backspace", true), "playing", Infinity)).toBeNull();
    expect(wishOf(press("Backspace"), "rewinding", Infinity)).toBeNull();
  });

  it("are those that were chosen, which go before all others", () => {
    const keys = { ...DEFAULT_KEYS, fire: ["KeyL"], rewind: ["KeyK"], pause: ["KeyP"] };
    const wish = (code: string, phase: "playing" | "paused" | "stepping" | "ended") =>
      wishOf(press(code), phase, Infinity, keys);
    expect(wish("KeyL", "playing")).toBeNull();
    expect(wish("KeyL", "paused")).toBe("go_on");
    expect(wish("KeyL", "stepping")).toBeNull();
    expect(wish("KeyL", "ended")).toBe("again");
    expect(wish("KeyK", "playing")).toBe("rewind");
    expect(wish("KeyP", "playing")).toBe("pause");
    expect(wish("KeyP", "stepping")).toBe("go_on");
    expect(wish("Escape", "playing")).toBe("pause");
    expect(wish("Backspace", "playing")).toBeNull();
  });

  it("change the speed in steps", () => {
    expect(wishOf(press("Minus"), "playing", Infinity)).toBe("slower");
    expect(wishOf(press("Equal"), "paused", Infinity)).toBe("faster");
    expect(speedBeside(100, "faster")).toBe(100);
    expect(speedBeside(100, "slower")).toBe(75);
    expect(speedBeside(25, "slower")).toBe(25);
    expect(speedBeside(60, "faster")).toBe(75);
    expect(speedBeside(50, "faster")).toBe(75);
  });

  it("show and hide what lies over the game, unless they were chosen for something else", () => {
    expect(wishOf(press("KeyT"), "playing", Infinity)).toBe("targets");
    expect(wishOf(press("KeyG"), "paused", Infinity)).toBe("ghost");
    expect(wishOf(press("KeyM"), "countdown", Infinity)).toBe("sound");
    const keys = { ...DEFAULT_KEYS, fire: ["KeyT"] };
    expect(wishOf(press("KeyT"), "playing", Infinity, keys)).toBeNull();
  });

  it("otherwise steer", () => {
    expect(wishOf(press("KeyD"), "playing", Infinity)).toBeNull();
    expect(wishOf(press("Space"), "playing", Infinity)).toBeNull();
    expect(steers("playing")).toBe(true);
    expect(steers("ended")).toBe(false);
  });
});

describe("buttons of a gamepad", () => {
  it("pause and go on", () => {
    expect(padWishOf(PAD.start, "playing", Infinity)).toBe("pause");
    expect(padWishOf(PAD.start, "paused", Infinity)).toBe("go_on");
    expect(padWishOf(PAD.bottom, "playing", Infinity)).toBeNull();
  });

  it("say what becomes of a game, once they can't be meant for it", () => {
    expect(padWishOf(PAD.bottom, "ended", GRACE_MS - 1)).toBeNull();
    expect([0, 1, 2, 3, 9].map((button) => padWishOf(button, "ended", GRACE_MS))).toEqual([
      "again",
      "discard",
      "keep",
      "perfect",
      "again",
    ]);
  });

  it("start the first game, and another one when a game is gone", () => {
    for (const phase of [null, "gone"] as const) {
      expect(padWishOf(PAD.start, phase, Infinity)).toBe("start");
      expect(padWishOf(PAD.bottom, phase, Infinity)).toBe("start");
      expect(padWishOf(PAD.top, phase, Infinity)).toBeNull();
    }
    expect(padWishOf(PAD.start, "connecting", Infinity)).toBeNull();
    expect(padWishOf(PAD.start, "elsewhere", Infinity)).toBeNull();
  });
});
