/** What a key or gamepad button asks of the play page, besides steering. */
import type { Phase } from "@/features/play/stream/game-state";
import { SPEEDS } from "@/features/play/stream/text-messages";
import { ofSigns, type Pressed } from "@/lib/browser/pressed-keys";

import { PAD } from "./gamepad";
import { type Control, controlOf, type KeyMap } from "./keys";

export type Intent =
  | "start"
  | "keep"
  | "discard"
  | "perfect"
  | "again"
  | "pause"
  | "go_on"
  | "step"
  | "rewind"
  | "slower"
  | "faster"
  | "latency"
  | "targets"
  | "ghost"
  | "sound"
  | "fullscreen";

/** Time after the end of a game in which firing and steering are taken as meant for the game. */
export const GRACE_MS = 700;

/** Measures the time since a game ended; firing or steering on in the grace begins it anew. */
export class SinceEnd {
  #playedOnAt = 0;

  /**
   * Returns the milliseconds since the end, or since the last press for the game in the grace.
   *
   * @param isForGame Whether the press would have fired or steered.
   */
  atPress(endedAt: number, now: number, isForGame: boolean): number {
    const sinceMs = now - Math.max(endedAt, this.#playedOnAt);
    if (isForGame && sinceMs < GRACE_MS) this.#playedOnAt = now;
    return sinceMs;
  }
}

/** By the signs that keys type. */
const AFTER_END: Readonly<Record<string, Intent>> = {
  k: "keep",
  Enter: "keep",
  x: "discard",
  Delete: "discard",
  p: "perfect",
  " ": "again",
  r: "again",
};

const AFTER_END_BY_CONTROL: Readonly<Record<Control, Intent>> = {
  fire: "again",
  rewind: "rewind",
};

const PAD_AFTER_END: Readonly<Record<number, Intent>> = {
  [PAD.bottom]: "again",
  [PAD.start]: "again",
  [PAD.right]: "discard",
  [PAD.left]: "keep",
  [PAD.top]: "perfect",
};

/** At any time during a game, unless the key is assigned to a control. */
const ANYTIME: Readonly<Record<string, Intent>> = {
  f: "fullscreen",
  l: "latency",
  t: "targets",
  g: "ghost",
  m: "sound",
  "-": "slower",
  "+": "faster",
  // On keyboards that type + with Shift.
  "=": "faster",
};

const RUNNING: Readonly<Record<string, Intent>> = { ...ANYTIME, Escape: "pause", ".": "pause" };

const PAUSED: Readonly<Record<string, Intent>> = {
  ...ANYTIME,
  ".": "step",
  Enter: "go_on",
  Escape: "go_on",
};

interface Press extends Pressed {
  readonly repeat: boolean;
}

/**
 * Returns the intent of a key press in a phase; null for none.
 *
 * @param phase Null before the first game.
 * @param sinceEndMs Milliseconds since the game ended.
 */
export function intentOf(
  press: Press,
  phase: Phase | null,
  sinceEndMs: number,
  keys: KeyMap,
): Intent | null {
  const intent = intentIn(press, phase, sinceEndMs, keys);
  // A held key steps frame by frame; no other intent repeats.
  return press.repeat && intent !== "step" ? null : intent;
}

function intentIn(
  press: Pressed,
  phase: Phase | null,
  sinceEndMs: number,
  keys: KeyMap,
): Intent | null {
  const control = controlOf(keys, press);
  const of = (table: Readonly<Record<string, Intent>>) => ofSigns(table, press) ?? null;
  switch (phase) {
    case null:
    case "gone":
      return of({ " ": "start" });
    case "playing":
    case "countdown":
      return control ? controlIntent(control, "pause") : of(RUNNING);
    case "paused":
      if (control === "fire") return "go_on";
      return control ? controlIntent(control, "go_on") : of(PAUSED);
    case "stepping":
      // The fire key fires here, unlike in a pause.
      return control ? controlIntent(control, "go_on") : of(PAUSED);
    case "ended": {
      // A key that still steers out of habit does nothing else.
      const intent = control ? (AFTER_END_BY_CONTROL[control] ?? null) : of(AFTER_END);
      // Firing on begins no new game; rewinding and deciding wait for nothing.
      return intent === "again" && sinceEndMs < GRACE_MS ? null : intent;
    }
    default:
      return null;
  }
}

function controlIntent(control: Control, pausing: Intent): Intent | null {
  if (control === "pause") return pausing;
  return control === "rewind" ? "rewind" : null;
}

/**
 * Returns the intent of pressing a gamepad button, besides steering and rewinding; null for none.
 *
 * @param phase Null before the first game.
 */
export function gamepadIntentOf(
  button: number,
  phase: Phase | null,
  sinceEndMs: number,
): Intent | null {
  switch (phase) {
    case null:
    case "gone":
      return button === PAD.start || button === PAD.bottom ? "start" : null;
    case "playing":
    case "countdown":
      return button === PAD.start ? "pause" : null;
    case "paused":
    case "stepping":
      return button === PAD.start ? "go_on" : null;
    case "ended":
      return sinceEndMs < GRACE_MS ? null : (PAD_AFTER_END[button] ?? null);
    default:
      return null;
  }
}

/** Whether keys steer the game in a phase. */
export function steers(phase: Phase): boolean {
  return ["playing", "countdown", "paused", "stepping", "rewinding"].includes(phase);
}

/** Returns the next slower or faster speed; the same one at either end. */
export function speedBeside(percent: number, way: "slower" | "faster"): number {
  const at = SPEEDS.findIndex((speed) => speed <= percent);
  return SPEEDS[at + (way === "slower" ? 1 : -1)] ?? percent;
}
