/** What a key asks of the page that watches. */
import { ofSigns, type Pressed, signsOf } from "@/lib/browser/pressed-keys";

export type WatchIntent =
  "toggle" | "step" | "slower" | "faster" | "restart" | "next" | { readonly takeOver: number };

const INTENTS: Readonly<Record<string, WatchIntent>> = {
  " ": "toggle",
  ".": "step",
  "-": "slower",
  "+": "faster",
  // On keyboards that type + with Shift.
  "=": "faster",
  r: "restart",
  n: "next",
};

interface Press extends Pressed {
  readonly repeat: boolean;
}

/** Returns the intent of a key press; null for none. */
export function watchIntentOf(press: Press, nLanes: number): WatchIntent | null {
  const intent = ofSigns(INTENTS, press) ?? takeOverOf(press, nLanes);
  // A held key plays step by step; nothing else repeats.
  return press.repeat && intent !== "step" ? null : intent;
}

/** The key that takes over a lane's game, as the page shows it. */
export function takeOverKey(lane: number, nLanes: number): string {
  return nLanes === 1 ? "T" : String(lane + 1);
}

function takeOverOf(pressed: Pressed, nLanes: number): WatchIntent | null {
  const signs = signsOf(pressed);
  if (signs.includes("t") && nLanes === 1) return { takeOver: 0 };
  const lane = Number(signs.find((sign) => /^[1-4]$/.test(sign))) - 1;
  return lane < nLanes ? { takeOver: lane } : null;
}

/** Percent of 60 frames per second, fastest first. */
export const WATCH_SPEEDS = [100, 50, 25] as const;

/** Returns the next slower or faster speed; the same one at either end. */
export function speedAfter(percent: number, way: "slower" | "faster"): number {
  const at = WATCH_SPEEDS.findIndex((speed) => speed <= percent);
  return WATCH_SPEEDS[at + (way === "slower" ? 1 : -1)] ?? percent;
}
