/** The keys that control the game, by their position on the keyboard (`KeyboardEvent.code`). */

import { t } from "@lingui/core/macro";
import { useMemo } from "react";

import type { TaughtGame } from "@/api/types";
import { type Setting, useSetting } from "@/features/play/settings/stored";
import { buttonName } from "@/games/actions";
import { useGame } from "@/games/game";
import { capitalised } from "@/games/words";
import { useKeyLabels } from "@/lib/browser/keyboard";
import { placeOf, type Pressed } from "@/lib/browser/pressed-keys";

/** What the keys of a game depend on. */
export type Keyed = Pick<TaughtGame, "buttons" | "default_keys" | "saves_states">;

/** What a key can be assigned to: a button of the game, "rewind" or "pause". */
export type Control = string;
/** The key codes of each control; no code is assigned twice. */
export type KeyMap = Readonly<Record<Control, readonly string[]>>;

/** Returns what keys can be assigned to in a game. */
export function controlsOf({ buttons, saves_states: canRewind }: Keyed): readonly Control[] {
  return [...buttons, ...(canRewind ? ["rewind"] : []), "pause"];
}

/** Names a control: "Left". */
export function controlName(control: Control): string {
  if (control === "rewind") return t`Rewind`;
  return control === "pause" ? t`Pause` : capitalised(buttonName(control));
}

/** The keys of a game, unless the player has chosen others. */
export function defaultKeys(game: Keyed): KeyMap {
  const codes = Object.entries(game.default_keys);
  const of = (button: string) => codes.filter(([, to]) => to === button).map(([code]) => code);
  return {
    ...Object.fromEntries(game.buttons.map((button) => [button, of(button)])),
    ...(game.saves_states && { rewind: ["Backspace"] }),
    pause: ["Escape"],
  };
}

/** Returns the control of a key; null if it has none. A key whose place has none may have the name of
 * another place: the arrows of a numeric pad.
 */
export function controlOf(keys: KeyMap, pressed: Pressed): Control | null {
  const at = (code: string) =>
    Object.keys(keys).find((control) => (keys[control] ?? []).includes(code));
  return at(placeOf(pressed)) ?? at(pressed.key) ?? null;
}

/** Returns the protocol bit of a key; 0 for none. */
export function bitOf(buttons: readonly string[], keys: KeyMap, pressed: Pressed): number {
  return buttonBit(buttons, controlOf(keys, pressed));
}

/** Returns the protocol bit of a button; 0 if the game has none of this name. */
export function buttonBit(buttons: readonly string[], name: string | null): number {
  const at = name === null ? -1 : buttons.indexOf(name);
  return at < 0 ? 0 : 1 << at;
}

/** Whether a key must not scroll the page: it steers, or lies among those that do. */
export function isGameKey(buttons: readonly string[], keys: KeyMap, pressed: Pressed): boolean {
  return bitOf(buttons, keys, pressed) !== 0 || pressed.key.startsWith("Arrow");
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
  return { ...without, [control]: [...(without[control] ?? []), code] };
}

/** Removes a key from its control. */
export function withoutKey(keys: KeyMap, code: string): KeyMap {
  const entries = Object.entries(keys).map(([control, codes]) => [
    control,
    codes.filter((other) => other !== code),
  ]);
  return Object.fromEntries(entries) as KeyMap;
}

/** Validates a stored key map of a game; null if it is invalid. */
export function readKeyMap(stored: unknown, game: Keyed): KeyMap | null {
  if (typeof stored !== "object" || stored === null) return null;
  const controls = controlsOf(game);
  const all = controls.map((control) => (stored as Record<string, unknown>)[control]);
  const codes = all.flat();
  const isWhole =
    all.every(Array.isArray) &&
    codes.every((code) => typeof code === "string" && isAssignable(code)) &&
    new Set(codes).size === codes.length;
  if (!isWhole) return null;
  return Object.fromEntries(controls.map((control, at) => [control, all[at]])) as KeyMap;
}

/** What the key maps of the first version are stored for. */
const FIRST_BUTTONS = "left,right,fire";

/** The keys that the player has chosen for games with the buttons of this one. */
export function keysSetting(game: Keyed): Setting<KeyMap> {
  const buttons = game.buttons.join(",");
  return {
    key: buttons === FIRST_BUTTONS ? "tril.play.keys" : `tril.play.keys.${buttons}`,
    fallback: defaultKeys(game),
    read: (stored) => readKeyMap(stored, game),
  };
}

/** Returns the keys of the page's game, and their setter. */
export function useKeyMap(): readonly [KeyMap, (keys: KeyMap) => void] {
  const game = useGame();
  return useSetting(useMemo(() => keysSetting(game), [game]));
}

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
