/** What a key press asks of the play page besides steering. Pure. */
import type { Phase } from "./game-stream";

export type Wish = "keep" | "discard" | "perfect" | "again" | "pause" | "go_on" | "latency";

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

const SHOWS_LATENCY = "KeyL";
const GOING_ON = new Set(["Space", "Enter", "Escape"]);

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
  if (press.repeat) return null;
  if (press.code === SHOWS_LATENCY && steers(phase)) return "latency";
  switch (phase) {
    case "playing":
    case "countdown":
      return press.code === "Escape" ? "pause" : null;
    case "paused":
      return GOING_ON.has(press.code) ? "go_on" : null;
    case "ended":
      return sinceEndMs < GRACE_MS ? null : (AFTER_END[press.code] ?? null);
    default:
      return null;
  }
}

/** Whether keys steer the game in this phase. */
export function steers(phase: Phase): boolean {
  return phase === "playing" || phase === "countdown" || phase === "paused";
}
