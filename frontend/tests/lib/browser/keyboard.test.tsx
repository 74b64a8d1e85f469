import { act, renderHook } from "@testing-library/react";
import { afterEach, describe, expect, it, vi } from "vitest";

import { followLayout, useKeyLabels } from "@/lib/browser/keyboard";
import { ofSigns, placeOf, signsOf } from "@/lib/browser/pressed-keys";

import { us } from "../../support/keyboard";

describe("the signs of a key", () => {
  it.each([
    ["US", us("KeyK"), ["k"]],
    ["with Shift or Caps Lock", { code: "KeyK", key: "K" }, ["k"]],
    ["German Z, where US keyboards have Y", { code: "KeyY", key: "z" }, ["z"]],
    ["German -", { code: "Slash", key: "-" }, ["-"]],
    ["German +", { code: "BracketRight", key: "+" }, ["+"]],
    ["German ü", { code: "BracketLeft", key: "ü" }, ["ü"]],
    ["French M", { code: "Semicolon", key: "m" }, ["m"]],
    ["French , where US keyboards have M", { code: "KeyM", key: "," }, [","]],
    ["French 1 without Shift", { code: "Digit1", key: "&" }, ["&", "1"]],
    ["French 2 without Shift", { code: "Digit2", key: "é" }, ["é", "2"]],
    ["Russian letter where US keyboards have K", { code: "KeyK", key: "л" }, ["k"]],
    ["Greek", { code: "KeyZ", key: "ζ" }, ["z"]],
    ["Arabic full stop", { code: "Period", key: "ز" }, ["."]],
    ["taken by an input method", { code: "KeyR", key: "Process" }, ["r"]],
    ["a dead key", { code: "Backquote", key: "Dead" }, []],
    ["an on-screen keyboard", { code: "", key: "x" }, ["x"]],
    ["the numeric pad", us("NumpadEnter"), ["Enter"]],
    ["the numeric pad's digits", { code: "Numpad4", key: "4" }, ["4", "4"]],
    ["a name", us("ArrowLeft"), ["ArrowLeft"]],
  ])("%s", (_keyboard, pressed, signs) => {
    expect(signsOf(pressed)).toEqual(signs);
  });

  it("are looked up by what they type before where they lie", () => {
    // A Czech 1 types + without Shift.
    expect(ofSigns({ "+": "faster", "1": "first" }, { code: "Digit1", key: "+" })).toBe("faster");
    expect(ofSigns({ "1": "first" }, { code: "Digit1", key: "+" })).toBe("first");
    expect(ofSigns({ k: "keep" }, us("KeyX"))).toBeUndefined();
    expect(ofSigns({}, { code: "", key: "constructor" })).toBeUndefined();
  });
});

describe("the place of a key", () => {
  it("is told by what it types where keyboards do not tell", () => {
    expect(placeOf({ code: "KeyA", key: "q" })).toBe("KeyA");
    expect(placeOf({ code: "", key: "A" })).toBe("KeyA");
    expect(placeOf({ code: "", key: " " })).toBe("Space");
    expect(placeOf({ code: "Unidentified", key: "ArrowLeft" })).toBe("ArrowLeft");
  });
});

describe("the labels of keys", () => {
  afterEach(() => vi.unstubAllGlobals());

  it("are the browser's where it tells, and learned as keys are pressed", async () => {
    const getLayoutMap = () => Promise.resolve(new Map([["KeyW", "z"]]));
    Object.defineProperty(navigator, "keyboard", { configurable: true, value: { getLayoutMap } });
    const { result } = renderHook(useKeyLabels);
    const stop = followLayout();
    await vi.waitFor(() => expect(result.current.get("KeyW")).toBe("z"));
    const press = (init: KeyboardEventInit) =>
      act(() => {
        window.dispatchEvent(new KeyboardEvent("keydown", init));
      });
    press({ code: "KeyA", key: "q" });
    const before = result.current.get("KeyD");
    press({ code: "KeyD", key: "E", shiftKey: true });
    press({ code: "BracketLeft", key: "Dead" });
    const learned = ["KeyW", "KeyA", "KeyD", "BracketLeft"].map((code) => result.current.get(code));
    expect(learned.map((label) => label ?? null)).toEqual(["z", "q", before ?? null, null]);
    // As other tests expect them.
    press({ code: "KeyW", key: "w" });
    press({ code: "KeyA", key: "a" });
    stop();
    press({ code: "IntlYen", key: "¥" });
    expect(result.current.has("IntlYen")).toBe(false);
    Reflect.deleteProperty(navigator, "keyboard");
  });
});
