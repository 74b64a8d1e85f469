import { describe, expect, it } from "vitest";

import { PAD } from "@/features/play/input/gamepad";
import {
  GRACE_MS,
  gamepadIntentOf,
  speedBeside,
  steers,
  intentOf as intentWith,
  SinceEnd,
} from "@/features/play/input/intents";
import { defaultKeys } from "@/features/play/input/keys";

import { SPACE_INVADERS } from "../../../support/games";
import { us } from "../../../support/keyboard";

const DEFAULT_KEYS = defaultKeys(SPACE_INVADERS);

function intentOf(...[pressed, phase, sinceEndMs, keys]: Asked) {
  return intentWith(pressed, phase, sinceEndMs, keys ?? DEFAULT_KEYS);
}
type Whole = Parameters<typeof intentWith>;
type Asked = [Whole[0], Whole[1], Whole[2], Whole[3]?];

const press = (code: string, repeat = false) => ({ ...us(code), repeat });

describe("keys after the end", () => {
  it.each([
    ["KeyK", "keep"],
    ["Enter", "keep"],
    ["KeyX", "discard"],
    ["KeyD", null],
    ["ArrowRight", null],
    ["KeyP", "perfect"],
    ["Space", "again"],
    ["KeyR", "again"],
    ["Backspace", "rewind"],
  ])("%s asks to %s", (code, intent) => {
    expect(intentOf(press(code), "ended", GRACE_MS)).toBe(intent);
  });

  it("are ignored during the grace period if they fire or steer, but not if they rewind", () => {
    expect(intentOf(press("Space"), "ended", GRACE_MS - 1)).toBeNull();
    expect(intentOf(press("ArrowLeft"), "ended", 0)).toBeNull();
    expect(intentOf(press("Backspace"), "ended", 0)).toBe("rewind");
    expect(intentOf(press("KeyK"), "ended", 0)).toBe("keep");
    expect(intentOf(press("Space", true), "ended", 10 * GRACE_MS)).toBeNull();
  });
});

describe("the time since the end", () => {
  it("begins anew at a press for the game in the grace period, and at no other", () => {
    const sinceEnd = new SinceEnd();
    const endedAt = 5_000;
    expect(sinceEnd.atPress(endedAt, endedAt + 600, true)).toBe(600);
    expect(sinceEnd.atPress(endedAt, endedAt + 1_200, true)).toBe(600);
    expect(sinceEnd.atPress(endedAt, endedAt + 1_500, false)).toBe(300);
    expect(sinceEnd.atPress(endedAt, endedAt + 1_200 + GRACE_MS, true)).toBe(GRACE_MS);
    expect(sinceEnd.atPress(endedAt, endedAt + 1_300 + GRACE_MS, true)).toBe(GRACE_MS + 100);
  });
});

describe("keys in the game", () => {
  it("pause it and go on", () => {
    expect(intentOf(press("Escape"), "playing", Infinity)).toBe("pause");
    expect(intentOf(press("Enter"), "paused", Infinity)).toBe("go_on");
    expect(intentOf(press("Space"), "paused", Infinity)).toBe("go_on");
  });

  it("play a paused game frame by frame, also when held", () => {
    expect(intentOf(press("Period"), "playing", Infinity)).toBe("pause");
    expect(intentOf(press("Period", true), "playing", Infinity)).toBeNull();
    expect(intentOf(press("Period"), "paused", Infinity)).toBe("step");
    expect(intentOf(press("Period", true), "stepping", Infinity)).toBe("step");
    expect(intentOf(press("Enter"), "stepping", Infinity)).toBe("go_on");
    expect(intentOf(press("Space"), "stepping", Infinity)).toBeNull();
    expect(steers("stepping")).toBe(true);
  });

  it("rewind the game, from a pause too", () => {
    for (const phase of ["playing", "countdown", "paused", "stepping"] as const) {
      expect(intentOf(press("Backspace"), phase, Infinity)).toBe("rewind");
    }
    expect(intentOf(press("Backspace", true), "playing", Infinity)).toBeNull();
    expect(intentOf(press("Backspace"), "rewinding", Infinity)).toBeNull();
  });

  it("are the assigned ones, which take precedence over shortcuts", () => {
    const keys = { ...DEFAULT_KEYS, fire: ["KeyL"], rewind: ["KeyK"], pause: ["KeyP"] };
    const intent = (code: string, phase: "playing" | "paused" | "stepping" | "ended") =>
      intentOf(press(code), phase, Infinity, keys);
    expect(intent("KeyL", "playing")).toBeNull();
    expect(intent("KeyL", "paused")).toBe("go_on");
    expect(intent("KeyL", "stepping")).toBeNull();
    expect(intent("KeyL", "ended")).toBe("again");
    expect(intent("KeyK", "playing")).toBe("rewind");
    expect(intent("KeyP", "playing")).toBe("pause");
    expect(intent("KeyP", "stepping")).toBe("go_on");
    expect(intent("Escape", "playing")).toBe("pause");
    expect(intent("Backspace", "playing")).toBeNull();
  });

  it("change the speed in steps", () => {
    expect(intentOf(press("Minus"), "playing", Infinity)).toBe("slower");
    expect(intentOf(press("Equal"), "paused", Infinity)).toBe("faster");
    expect(speedBeside(100, "faster")).toBe(100);
    expect(speedBeside(100, "slower")).toBe(75);
    expect(speedBeside(25, "slower")).toBe(25);
    expect(speedBeside(60, "faster")).toBe(75);
    expect(speedBeside(50, "faster")).toBe(75);
  });

  it("mean what is printed on a German or French keyboard, and steer by their place", () => {
    const intent = (code: string, key: string, phase: "playing" | "ended") =>
      intentOf({ code, key, repeat: false }, phase, Infinity);
    expect(intent("Slash", "-", "playing")).toBe("slower");
    expect(intent("BracketRight", "+", "playing")).toBe("faster");
    expect(intent("Minus", "ß", "playing")).toBeNull();
    expect(intent("Semicolon", "m", "playing")).toBe("sound");
    expect(intent("KeyM", ",", "playing")).toBeNull();
    expect(intent("Comma", ".", "playing")).toBe("pause");
    expect(intent("KeyK", "л", "ended")).toBe("keep");
    // It steers, whatever it types.
    expect(intent("KeyA", "x", "ended")).toBeNull();
  });

  it("show and hide what lies over the game, unless they were chosen for something else", () => {
    expect(intentOf(press("KeyT"), "playing", Infinity)).toBe("targets");
    expect(intentOf(press("KeyG"), "paused", Infinity)).toBe("ghost");
    expect(intentOf(press("KeyM"), "countdown", Infinity)).toBe("sound");
    const keys = { ...DEFAULT_KEYS, fire: ["KeyT"] };
    expect(intentOf(press("KeyT"), "playing", Infinity, keys)).toBeNull();
  });

  it("otherwise steer", () => {
    expect(intentOf(press("KeyD"), "playing", Infinity)).toBeNull();
    expect(intentOf(press("Space"), "playing", Infinity)).toBeNull();
    expect(steers("playing")).toBe(true);
    expect(steers("ended")).toBe(false);
  });
});

describe("buttons of a gamepad", () => {
  it("pause and go on", () => {
    expect(gamepadIntentOf(PAD.start, "playing", Infinity)).toBe("pause");
    expect(gamepadIntentOf(PAD.start, "paused", Infinity)).toBe("go_on");
    expect(gamepadIntentOf(PAD.bottom, "playing", Infinity)).toBeNull();
  });

  it("decide on an ended game, after a grace period", () => {
    expect(gamepadIntentOf(PAD.bottom, "ended", GRACE_MS - 1)).toBeNull();
    expect([0, 1, 2, 3, 9].map((button) => gamepadIntentOf(button, "ended", GRACE_MS))).toEqual([
      "again",
      "discard",
      "keep",
      "perfect",
      "again",
    ]);
  });

  it("start the first game, and another one when a game is gone", () => {
    for (const phase of [null, "gone"] as const) {
      expect(gamepadIntentOf(PAD.start, phase, Infinity)).toBe("start");
      expect(gamepadIntentOf(PAD.bottom, phase, Infinity)).toBe("start");
      expect(gamepadIntentOf(PAD.top, phase, Infinity)).toBeNull();
    }
    expect(gamepadIntentOf(PAD.start, "connecting", Infinity)).toBeNull();
    expect(gamepadIntentOf(PAD.start, "elsewhere", Infinity)).toBeNull();
  });
});
