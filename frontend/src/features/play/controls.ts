/** What a key press asks of the play page besides steering. Pure. */
import type { Phase } from "./game-stream";
import { type Ended, SPEEDS } from "./messages";

import { FRAME_RATE_HZ } from "@/lib/format";

export type Wish =
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
  | "latency";

/** Time after the end in which presses are still meant for the game. */
export const GRACE_MS = 700;

const CHANCE_FRAMES = 2 * FRAME_RATE_HZ;

const AFTER_END: Readonly<Record<string, Wish>> = {
  KeyK: "keep",
  Enter: "keep",
  NumpadEnter: "keep",
  KeyD: "discard",
  KeyP: "perfect",
  Space: "again",
  KeyR: "again",
  Backspace: "rewind",
};

/** Runs the game back while it is held. */
export const REWIND_CODE = "Backspace";

/** At any time of a game. */
const BESIDE: Readonly<Record<string, Wish>> = {
  KeyL: "latency",
  [REWIND_CODE]: "rewind",
  Minus: "slower",
  NumpadSubtract: "slower",
  Equal: "faster",
  NumpadAdd: "faster",
};

const RUNNING: Readonly<Record<string, Wish>> = { Escape: "pause", Period: "pause" };

const STEPPING: Readonly<Record<string, Wish>> = {
  Period: "step",
  Enter: "go_on",
  NumpadEnter: "go_on",
  Escape: "go_on",
};

// Who plays frame by frame may fire with the space bar.
const PAUSED: Readonly<Record<string, Wish>> = { ...STEPPING, Space: "go_on" };

interface Press {
  readonly code: string;
  readonly repeat: boolean;
}

/**
 * What a press means in a phase.
 *
 * @param sinceEndMs Milliseconds since the game ended.
 */
export function wishOf(press: Press, phase: Phase, sinceEndMs: number): Wish | null {
  const wish = meaning(press.code, phase, sinceEndMs);
  // A held key runs a paused game on, frame by frame; nothing else is meant to happen twice.
  return press.repeat && wish !== "step" ? null : wish;
}

function meaning(code: string, phase: Phase, sinceEndMs: number): Wish | null {
  switch (phase) {
    case "playing":
    case "countdown":
      return RUNNING[code] ?? BESIDE[code] ?? null;
    case "paused":
      return PAUSED[code] ?? BESIDE[code] ?? null;
    case "stepping":
      return STEPPING[code] ?? BESIDE[code] ?? null;
    case "ended":
      return sinceEndMs < GRACE_MS ? null : (AFTER_END[code] ?? null);
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

/** From which frame an ended game can be played on, in time to do something else. */
export function lastChanceOf({ frame }: Pick<Ended, "frame">): number {
  return Math.max(0, frame - CHANCE_FRAMES);
}
