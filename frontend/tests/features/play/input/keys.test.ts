import fc from "fast-check";
import { describe, expect, it } from "vitest";

import {
  addKey,
  bitOf as bitWith,
  controlOf,
  controlsOf,
  defaultKeys,
  HeldKeys,
  isAssignable,
  isGameKey as isGameKeyWith,
  type KeyMap,
  keyName,
  keysSetting,
  readKeyMap as readWith,
  withoutKey,
} from "@/features/play/input/keys";

import { BLACKJACK, MS_PACMAN, PONG, SPACE_INVADERS } from "../../../support/games";
import { us } from "../../../support/keyboard";

const [LEFT, RIGHT, FIRE] = [1, 2, 4];
const CONTROLS = controlsOf(SPACE_INVADERS);
const DEFAULT_KEYS = defaultKeys(SPACE_INVADERS);
const { buttons: BUTTONS } = SPACE_INVADERS;
const bitOf = (keys: KeyMap, pressed: ReturnType<typeof us>) => bitWith(BUTTONS, keys, pressed);
const isGameKey = (keys: KeyMap, pressed: ReturnType<typeof us>) =>
  isGameKeyWith(BUTTONS, keys, pressed);
const readKeyMap = (stored: unknown) => readWith(stored, SPACE_INVADERS);

const CODES = ["ArrowLeft", "ArrowRight", "ArrowUp", "KeyA", "KeyD", "KeyW", "Space", "KeyJ"];

describe("held keys", () => {
  it("add up", () => {
    const held = new HeldKeys();
    expect(held.hold("ArrowLeft", LEFT)).toBe(true);
    expect(held.hold("Space", FIRE)).toBe(true);
    expect(held.bits).toBe(LEFT | FIRE);
    expect(held.release("ArrowLeft")).toBe(true);
    expect(held.bits).toBe(FIRE);
  });

  it("stay held while another key for the same is", () => {
    const held = new HeldKeys();
    held.hold("ArrowRight", RIGHT);
    expect(held.hold("KeyD", RIGHT)).toBe(false);
    expect(held.release("ArrowRight")).toBe(false);
    expect(held.bits).toBe(RIGHT);
  });

  it("take no notice of other keys, nor of a key's repetition", () => {
    const held = new HeldKeys();
    expect(held.hold("KeyQ", 0)).toBe(false);
    held.hold("Space", FIRE);
    expect(held.hold("Space", FIRE)).toBe(false);
  });

  it("are all let go at once", () => {
    const held = new HeldKeys();
    expect(held.releaseAll()).toBe(false);
    held.hold("Space", FIRE);
    held.hold("finger-1", LEFT);
    expect(held.releaseAll()).toBe(true);
    expect(held.bits).toBe(0);
  });

  it("are none once each pressed key is released, in any order", () => {
    fc.assert(
      fc.property(fc.array(fc.constantFrom(...CODES)), (pressed) => {
        const held = new HeldKeys();
        pressed.forEach((code) => held.hold(code, bitOf(DEFAULT_KEYS, us(code))));
        [...new Set(pressed)].reverse().forEach((code) => held.release(code));
        expect(held.bits).toBe(0);
      }),
    );
  });
});

describe("the key map", () => {
  it("lets either hand play alone", () => {
    const bits = (codes: string[]) => codes.map((code) => bitOf(DEFAULT_KEYS, us(code)));
    expect(bits(["ArrowLeft", "ArrowRight", "ArrowUp"])).toEqual([LEFT, RIGHT, FIRE]);
    expect(bits(["KeyA", "KeyD", "KeyW"])).toEqual([LEFT, RIGHT, FIRE]);
  });

  it("is that of the game: one key or more for each of its buttons", () => {
    const bits = (codes: string[]) =>
      codes.map((code) => bitWith(MS_PACMAN.buttons, defaultKeys(MS_PACMAN), us(code)));
    expect(bits(["ArrowLeft", "KeyD", "KeyW", "ArrowDown", "Space"])).toEqual([1, 2, 4, 8, 0]);
    expect(defaultKeys({ ...BLACKJACK, saves_states: false })).toEqual({
      stick: ["Space"],
      hit: ["Digit1"],
      pause: ["Escape"],
    });
  });

  it("is kept for each set of buttons, and that of the first version stays", () => {
    expect(keysSetting(SPACE_INVADERS).key).toBe("tril.play.keys");
    expect(keysSetting(PONG).key).toBe("tril.play.keys.down,up,fire");
    expect(keysSetting(BLACKJACK).key).toBe("tril.play.keys.stick,hit");
    expect(keysSetting(MS_PACMAN).read(DEFAULT_KEYS)).toBeNull();
  });

  it("includes the key that would scroll", () => {
    expect(isGameKey(DEFAULT_KEYS, us("ArrowDown"))).toBe(true);
    expect(isGameKey(DEFAULT_KEYS, us("Space"))).toBe(true);
    expect(isGameKey(DEFAULT_KEYS, us("Backspace"))).toBe(false);
  });

  it("gives each key to one control only, and survives being stored", () => {
    const change = fc.tuple(fc.constantFrom(...CONTROLS), fc.constantFrom(...CODES), fc.boolean());
    fc.assert(
      fc.property(fc.array(change), (changes) => {
        let keys = DEFAULT_KEYS;
        for (const [control, code, add] of changes) {
          keys = add ? addKey(keys, control, code) : withoutKey(keys, code);
          expect(controlOf(keys, us(code))).toBe(add ? control : null);
        }
        expect(readKeyMap(JSON.parse(JSON.stringify(keys)))).toEqual(keys);
      }),
    );
  });

  it.each([
    null,
    3,
    [],
    { ...DEFAULT_KEYS, left: "KeyA" },
    { ...DEFAULT_KEYS, left: [3] },
    { ...DEFAULT_KEYS, left: ["Space"] },
    { left: [] },
    { ...DEFAULT_KEYS, fire: ["ControlLeft"] },
    { ...DEFAULT_KEYS, fire: [""] },
  ])("is not read from %j", (stored) => {
    expect(readKeyMap(stored)).toBeNull();
  });

  it("finds a place by the name of a key", () => {
    expect(controlOf(DEFAULT_KEYS, { code: "Numpad4", key: "ArrowLeft" })).toBe("left");
    expect(controlOf(DEFAULT_KEYS, { code: "Numpad4", key: "4" })).toBeNull();
    expect(controlOf(DEFAULT_KEYS, { code: "", key: "d" })).toBe("right");
    expect(controlOf(DEFAULT_KEYS, { code: "KeyA", key: "q" })).toBe("left");
    expect(controlOf(DEFAULT_KEYS, { code: "KeyQ", key: "a" })).toBeNull();
  });

  it("gives no control a key that the browser or the system takes", () => {
    expect(["ControlLeft", "AltRight", "MetaLeft", "CapsLock", "Tab", ""].some(isAssignable)).toBe(
      false,
    );
    expect(["ShiftLeft", "KeyA", "Enter", "F8"].every(isAssignable)).toBe(true);
  });

  it("names keys as they are printed on a French keyboard", () => {
    const labels = new Map([
      ["KeyA", "q"],
      ["Digit1", "&"],
      ["KeyS", "ß"],
      ["Space", "x"],
    ]);
    expect(["KeyA", "Digit1", "KeyS", "Space"].map((code) => keyName(code, labels))).toEqual([
      "Q",
      "&",
      "ß",
      "Space",
    ]);
  });

  it("names keys as they are written", () => {
    expect(
      ["ArrowLeft", "KeyA", "Digit7", "Space", "Numpad4", "Escape"].map((code) => keyName(code)),
    ).toEqual(["←", "A", "7", "Space", "Num 4", "Esc"]);
  });
});
