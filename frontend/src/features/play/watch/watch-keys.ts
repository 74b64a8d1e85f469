/** What a key asks of the page that watches. */

export type WatchIntent =
  "toggle" | "step" | "slower" | "faster" | "restart" | "next" | { readonly takeOver: number };

const INTENTS: Readonly<Record<string, WatchIntent>> = {
  Space: "toggle",
  Period: "step",
  Minus: "slower",
  NumpadSubtract: "slower",
  Equal: "faster",
  NumpadAdd: "faster",
  KeyR: "restart",
  KeyN: "next",
};

interface Press {
  readonly code: string;
  readonly repeat: boolean;
}

/** Returns the intent of a key press; null for none. */
export function watchIntentOf({ code, repeat }: Press, nLanes: number): WatchIntent | null {
  const intent = INTENTS[code] ?? takeOverOf(code, nLanes);
  // A held key plays step by step; nothing else repeats.
  return repeat && intent !== "step" ? null : intent;
}

/** The key that takes over a lane's game, as the page shows it. */
export function takeOverKey(lane: number, nLanes: number): string {
  return nLanes === 1 ? "T" : String(lane + 1);
}

function takeOverOf(code: string, nLanes: number): WatchIntent | null {
  if (code === "KeyT" && nLanes === 1) return { takeOver: 0 };
  const digit = /^(?:Digit|Numpad)([1-4])$/.exec(code)?.[1];
  const lane = Number(digit) - 1;
  return digit !== undefined && lane < nLanes ? { takeOver: lane } : null;
}

/** Percent of 60 frames per second, fastest first. */
export const WATCH_SPEEDS = [100, 50, 25] as const;

/** Returns the next slower or faster speed; the same one at either end. */
export function speedAfter(percent: number, way: "slower" | "faster"): number {
  const at = WATCH_SPEEDS.findIndex((speed) => speed <= percent);
  return WATCH_SPEEDS[at + (way === "slower" ? 1 : -1)] ?? percent;
}
