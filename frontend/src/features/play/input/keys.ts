/** The keys that control the game, by their position on the keyboard (`KeyboardEvent.code`). */

import { t } from "@lingui/core/macro";

import type { Setting } from "@/features/play/settings/stored";
import { placeOf, type Pressed, useKeyLabels } from "@/lib/browser/keyboard";

/** Bits of the play protocol's held keys. */
export const LEFT = 1;
export const RIGHT = 2;
export const FIRE = 4;

export const CONTROLS = ["left", "right", "fire", "rewind", "pause"] as const;
/** What a key can be assigned to. */
export type Control = (typeof CONTROLS)[number];
/** The key codes of each control; no code is assigned twice. */
export type KeyMap = Readonly<Record<Control, readonly string[]>>;

/** Either hand can steer and fire alone: the arrows, or A, D and W. */
export const DEFAULT_KEYS: KeyMap = {
  left: ["ArrowLeft", "KeyA"],
  right: ["ArrowRight", "KeyD"],
  fire: ["Space", "ArrowUp", "KeyW"],
  rewind: ["Backspace"],
  pause: ["Escape"],
};

const BITS: Readonly<Record<Control, number>> = {
  left: LEFT,
  right: RIGHT,
  fire: FIRE,
  rewind: 0,
  pause: 0,
};

/**
 * Returns the control of a key; null if it has none. A key whose place has none may have the name of
 * another place: the arrows of a numeric pad.
 */
export function controlOf(keys: KeyMap, pressed: Pressed): Control | null {
  const at = (code: string) => CONTROLS.find((control) => keys[control].includes(code));
  return at(placeOf(pressed)) ?? at(pressed.key) ?? null;
}

/** Returns the protocol bit of a key; 0 for none. */
export function bitOf(keys: KeyMap, pressed: Pressed): number {
  const control = controlOf(keys, pressed);
  return control === null ? 0 : BITS[control];
}

/** Whether a key must not scroll the page: it steers, or lies among those that do. */
export function isGameKey(keys: KeyMap, pressed: Pressed): boolean {
  return bitOf(keys, pressed) !== 0 || pressed.key === "ArrowDown";
}

/** Keys of which the browser or the system swallows something, or that change what others do. */
const UNASSIGNABLE =
  /^(?:Control|Alt|Meta|OS)(?:Left|Right)$|^(?:CapsLock|NumLock|Fn|FnLock|Tab|)$/;

/** Whether a key can be assigned to a control. */
export function isAssignable(code: string): boolean {
  return !UNASSIGNABLE.test(code);
}

/** Assigns a key to a control, removing it from any other. */
export function addKey(keys: KeyMap, control: Control, code: string): KeyMap {
  const without = withoutKey(keys, code);
  return { ...without, [control]: [...without[control], code] };
}

/** Removes a key from its control. */
export function withoutKey(keys: KeyMap, code: string): KeyMap {
  const entries = CONTROLS.map((control) => [
    control,
    keys[control].filter((other) => other !== code),
  ]);
  return Object.fromEntries(entries) as KeyMap;
}

/** Validates a stored key map; null if it is invalid. */
export function readKeyMap(stored: unknown): KeyMap | null {
  if (typeof stored !== "object" || stored === null) return null;
  const all = CONTROLS.map((control) => (stored as Record<string, unknown>)[control]);
  const codes = all.flat();
  const isWhole =
    all.every(Array.isArray) &&
    codes.every((code) => typeof code === "string" && isAssignable(code)) &&
    new Set(codes).size === codes.length;
  return isWhole ? (stored as KeyMap) : null;
}

export const KEYS: Setting<KeyMap> = {
  key: "tril.play.keys",
  fallback: DEFAULT_KEYS,
  read: readKeyMap,
};

const names = (): Readonly<Record<string, string>> => ({
  ArrowLeft: "←",
  ArrowRight: "→",
  ArrowUp: "↑",
  ArrowDown: "↓",
  Backspace: "⌫",
  Escape: t`Esc`,
  Space: t`Space`,
});

/**
 * The label of a key: what is printed on it where that is known, else what is on most keyboards: "A"
 * for "KeyA".
 *
 * @param labels By code.
 */
export function keyName(code: string, labels: ReadonlyMap<string, string> = new Map()): string {
  const label = labels.get(code)?.toUpperCase() ?? "";
  // Some letters have no upper case of their own.
  const printed = /^\S$/u.test(label) ? label : labels.get(code)?.trim();
  const place = code.replace(/^(Key|Digit)(?=.$)/, "").replace(/^Numpad/, "Num ");
  return names()[code] ?? (printed === undefined || printed === "" ? place : printed);
}

/** Names keys as they are printed on this keyboard. */
export function useKeyNames(): (code: string) => string {
  const labels = useKeyLabels();
  return (code) => keyName(code, labels);
}

/** The keys, touch buttons and gamepad buttons currently held. */
export class HeldKeys {
  private readonly held = new Map<string, number>();

  /** Sets the bits that a source, such as a key or a finger, holds; returns whether `bits` changed. */
  hold(name: string, bits: number): boolean {
    const before = this.bits;
    if (bits === 0) this.held.delete(name);
    else this.held.set(name, bits);
    return this.bits !== before;
  }

  release(name: string): boolean {
    return this.hold(name, 0);
  }

  /** Releases everything, as when the window loses the focus; returns whether `bits` changed. */
  releaseAll(): boolean {
    const before = this.bits;
    this.held.clear();
    return before !== 0;
  }

  get bits(): number {
    let bits = 0;
    for (const bit of this.held.values()) bits |= bit;
    return bits;
  }
}
