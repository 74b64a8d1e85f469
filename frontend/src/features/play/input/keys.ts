/** Which keys steer the game, by their place on the keyboard (`KeyboardEvent.code`). */
import type { Setting } from "@/features/play/settings/stored";

/** Bits of the keys held, as the play protocol sends them. */
export const LEFT = 1;
export const RIGHT = 2;
export const FIRE = 4;

export const CONTROLS = ["left", "right", "fire", "rewind", "pause"] as const;
/** What a key can be chosen for. */
export type Control = (typeof CONTROLS)[number];
/** The codes of the keys for each control; no code stands for two. */
export type KeyMap = Readonly<Record<Control, readonly string[]>>;

/** Either hand alone can steer and fire: the arrows, or A, D and W. */
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

/** What a key is for; null if for nothing. */
export function controlOf(keys: KeyMap, code: string): Control | null {
  return CONTROLS.find((control) => keys[control].includes(code)) ?? null;
}

/** The bit of the game's key that a key holds; 0 for none. */
export function bitOf(keys: KeyMap, code: string): number {
  const control = controlOf(keys, code);
  return control === null ? 0 : BITS[control];
}

/** Whether the page must not scroll by a key, because it steers or lies beside those that do. */
export function isGameKey(keys: KeyMap, code: string): boolean {
  return bitOf(keys, code) !== 0 || code === "ArrowDown";
}

/** Gives a control one more key, which it is taken from another one for. */
export function addKey(keys: KeyMap, control: Control, code: string): KeyMap {
  const without = withoutKey(keys, code);
  return { ...without, [control]: [...without[control], code] };
}

/** Takes a key from whatever it was for. */
export function withoutKey(keys: KeyMap, code: string): KeyMap {
  const entries = CONTROLS.map((control) => [
    control,
    keys[control].filter((other) => other !== code),
  ]);
  return Object.fromEntries(entries) as KeyMap;
}

/** Reads a stored choice of keys; null if it is none. */
export function readKeyMap(stored: unknown): KeyMap | null {
  if (typeof stored !== "object" || stored === null) return null;
  const all = CONTROLS.map((control) => (stored as Record<string, unknown>)[control]);
  const codes = all.flat();
  const isWhole =
    all.every(Array.isArray) &&
    codes.every((code) => typeof code === "string") &&
    new Set(codes).size === codes.length;
  return isWhole ? (stored as KeyMap) : null;
}

export const KEYS: Setting<KeyMap> = {
  key: "tril.play.keys",
  fallback: DEFAULT_KEYS,
  read: readKeyMap,
};

const NAMES: Readonly<Record<string, string>> = {
  ArrowLeft: "←",
  ArrowRight: "→",
  ArrowUp: "↑",
  ArrowDown: "↓",
  Backspace: "⌫",
  Escape: "Esc",
};

/** What is written on a key, on most keyboards: "A" of "KeyA". */
export function keyName(code: string): string {
  return NAMES[code] ?? code.replace(/^(Key|Digit)(?=.$)/, "").replace(/^Numpad/, "Num ");
}

/** The keys (and touch buttons) held at the moment. */
export class HeldKeys {
  private readonly held = new Map<string, number>();

  /** Something named `name` holds keys of the game, such as a key or a finger on a button. */
  hold(name: string, bits: number): boolean {
    const before = this.bits;
    if (bits === 0) this.held.delete(name);
    else this.held.set(name, bits);
    return this.bits !== before;
  }

  release(name: string): boolean {
    return this.hold(name, 0);
  }

  /** Everything is let go, as when the window loses the keyboard. */
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
