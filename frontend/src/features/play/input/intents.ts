/** What a key press asks of the play page besides steering. Pure. */
import type { Phase } from "@/features/play/stream/game-stream";
import { SPEEDS } from "@/features/play/stream/text-messages";

import { PAD } from "./gamepad";
import { type Control, controlOf, DEFAULT_KEYS, type KeyMap } from "./keys";

export type Wish =
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

/** Time after the end in which presses are still meant for the game. */
export const GRACE_MS = 700;

const AFTER_END: Readonly<Record<string, Wish>> = {
  KeyK: "keep",
  Enter: "keep",
  NumpadEnter: "keep",
  KeyD: "discard",
  KeyP: "perfect",
  Space: "again",
  KeyR: "again",
};

const AFTER_END_BY_CONTROL: Readonly<Partial<Record<Control, Wish>>> = {
  fire: "again",
  rewind: "rewind",
};

const PAD_AFTER_END: Readonly<Record<number, Wish>> = {
  [PAD.bottom]: "again",
  [PAD.start]: "again",
  [PAD.right]: "discard",
  [PAD.left]: "keep",
  [PAD.top]: "perfect",
};

/** At any time of a game, unless the key was chosen for something else. */
const BESIDE: Readonly<Record<string, Wish>> = {
  KeyF: "fullscreen",
  KeyL: "latency",
  KeyT: "targets",
  KeyG: "ghost",
  KeyM: "sound",
  Minus: "slower",
  NumpadSubtract: "slower",
  Equal: "faster",
  NumpadAdd: "faster",
};

const RUNNING: Readonly<Record<string, Wish>> = { Escape: "pause", Period: "pause" };

const STANDING: Readonly<Record<string, Wish>> = {
  Period: "step",
  Enter: "go_on",
  NumpadEnter: "go_on",
  Escape: "go_on",
};

interface Press {
  readonly code: string;
  readonly repeat: boolean;
}

/**
 * What a press means in a phase.
 *
 * @param sinceEndMs Milliseconds since the game ended.
 */
export function wishOf(
  press: Press,
  phase: Phase,
  sinceEndMs: number,
  keys: KeyMap = DEFAULT_KEYS,
): Wish | null {
  const wish = meaning(press.code, phase, sinceEndMs, keys);
  // A held key runs a paused game on, frame by frame; nothing else is meant to happen twice.
  return press.repeat && wish !== "step" ? null : wish;
}

function meaning(code: string, phase: Phase, sinceEndMs: number, keys: KeyMap): Wish | null {
  const control = controlOf(keys, code);
  switch (phase) {
    case "playing":
    case "countdown":
      return control ? chosen(control, "pause") : (RUNNING[code] ?? BESIDE[code] ?? null);
    case "paused":
      if (control === "fire") return "go_on";
      return control ? chosen(control, "go_on") : (STANDING[code] ?? BESIDE[code] ?? null);
    case "stepping":
      // Who plays frame by frame may fire.
      return control ? chosen(control, "go_on") : (STANDING[code] ?? BESIDE[code] ?? null);
    case "ended":
      if (sinceEndMs < GRACE_MS) return null;
      return AFTER_END[code] ?? AFTER_END_BY_CONTROL[control ?? "left"] ?? null;
    default:
      return null;
  }
}

function chosen(control: Control, pausing: Wish): Wish | null {
  if (control === "pause") return pausing;
  return control === "rewind" ? "rewind" : null;
}

/**
 * What a button of a gamepad asks for when it goes down, besides steering and rewinding.
 *
 * @param phase Null before the first game.
 */
export function padWishOf(button: number, phase: Phase | null, sinceEndMs: number): Wish | null {
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

/** Whether keys steer the game in this phase. */
export function steers(phase: Phase): boolean {
  return ["playing", "countdown", "paused", "stepping", "rewinding"].includes(phase);
}

/** The next speed in a direction; the same at the end. */
export function speedBeside(percent: number, way: "slower" | "faster"): number {
  const at = SPEEDS.findIndex((speed) => speed <= percent);
  return SPEEDS[at + (way === "slower" ? 1 : -1)] ?? percent;
}
