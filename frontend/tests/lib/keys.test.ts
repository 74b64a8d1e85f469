import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { FIRE, HeldKeys, isGameKey, LEFT, RIGHT } from "@/lib/keys";

describe("held keys", () => {
  it("add up by their place on the keyboard", () => {
    const keys = new HeldKeys();
    expect(keys.press("ArrowLeft")).toBe(true);
    expect(keys.press("Space")).toBe(true);
    expect(keys.bits).toBe(LEFT | FIRE);
    expect(keys.release("ArrowLeft")).toBe(true);
    expect(keys.bits).toBe(FIRE);
  });

  it("stay held while another key for the same is", () => {
    const keys = new HeldKeys();
    keys.press("ArrowRight");
    expect(keys.press("KeyD")).toBe(false);
    expect(keys.release("ArrowRight")).toBe(false);
    expect(keys.bits).toBe(RIGHT);
  });

  it("take no notice of other keys, nor of a key's repetition", () => {
    const keys = new HeldKeys();
    expect(keys.press("KeyQ")).toBe(false);
    keys.press("Space");
    expect(keys.press("Space")).toBe(false);
  });

  it("are all let go at once", () => {
    const keys = new HeldKeys();
    expect(keys.releaseAll()).toBe(false);
    keys.press("Space");
    keys.hold("finger-1", LEFT);
    expect(keys.releaseAll()).toBe(true);
    expect(keys.bits).toBe(0);
  });

  it("are none once each pressed key is released, in any order", () => {
    const codes = ["ArrowLeft", "ArrowRight", "ArrowUp", "KeyA", "KeyD", "KeyW", "Space"];
    fc.assert(
      fc.property(fc.array(fc.constantFrom(...codes)), (pressed) => {
        const keys = new HeldKeys();
        pressed.forEach((code) => keys.press(code));
        [...new Set(pressed)].reverse().forEach((code) => keys.release(code));
        expect(keys.bits).toBe(0);
      }),
    );
  });

  it("that steer include the one that would scroll", () => {
    expect(isGameKey("ArrowDown")).toBe(true);
    expect(isGameKey("Enter")).toBe(false);
  });
});
