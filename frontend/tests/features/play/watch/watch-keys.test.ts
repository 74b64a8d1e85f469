import { describe, expect, it } from "vitest";

import { speedAfter, takeOverKey, watchIntentOf } from "@/features/play/watch/watch-keys";

import { us } from "../../../support/keyboard";

const press = (code: string, repeat = false) => ({ ...us(code), repeat });

describe("the keys of the page that watches", () => {
  it("pause, step and restart", () => {
    expect(watchIntentOf(press("Space"), 1)).toBe("toggle");
    expect(watchIntentOf(press("Period"), 1)).toBe("step");
    expect(watchIntentOf(press("KeyR"), 1)).toBe("restart");
    expect(watchIntentOf(press("KeyQ"), 1)).toBeNull();
  });

  it("repeat single steps only", () => {
    expect(watchIntentOf(press("Period", true), 1)).toBe("step");
    expect(watchIntentOf(press("Space", true), 1)).toBeNull();
  });

  it("take over the only game by T, and any by its number", () => {
    expect(watchIntentOf(press("KeyT"), 1)).toEqual({ takeOver: 0 });
    expect(watchIntentOf(press("KeyT"), 2)).toBeNull();
    expect(watchIntentOf(press("Digit2"), 2)).toEqual({ takeOver: 1 });
    expect(watchIntentOf(press("Digit3"), 2)).toBeNull();
    const french = { code: "Digit2", key: "é", repeat: false };
    expect(watchIntentOf(french, 2)).toEqual({ takeOver: 1 });
    expect([takeOverKey(0, 1), takeOverKey(1, 3)]).toEqual(["T", "2"]);
  });

  it("change the speed by the signs that are shown, on any keyboard", () => {
    expect(watchIntentOf(press("Minus"), 1)).toBe("slower");
    expect(watchIntentOf(press("Equal"), 1)).toBe("faster");
    const german = { code: "BracketRight", key: "+", repeat: false };
    expect(watchIntentOf(german, 1)).toBe("faster");
  });

  it("change the speed by one", () => {
    expect(speedAfter(100, "slower")).toBe(50);
    expect(speedAfter(25, "slower")).toBe(25);
    expect(speedAfter(50, "faster")).toBe(100);
    expect(speedAfter(100, "faster")).toBe(100);
  });
});
