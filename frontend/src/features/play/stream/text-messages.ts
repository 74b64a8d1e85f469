/** The text messages of the play protocol (docs/protocol.md). */
import type { Overlay } from "@/games/view";
import type { ScreenFormat } from "@/lib/game/screen";

export interface HitAt {
  readonly row: number;
  readonly column: number;
  readonly frame: number;
  readonly on_target: boolean | null;
}

interface Hello extends ScreenFormat {
  readonly type: "hello";
  readonly max_frames: number;
  readonly frame: number;
  readonly resumed: boolean;
  readonly hits: readonly HitAt[];
  readonly speed_percent: number;
  readonly overlay: Overlay | null;
}

interface Countdown {
  readonly type: "countdown";
  readonly seconds: number;
}

interface HitMessage extends HitAt {
  readonly type: "hit";
}

interface Paused {
  readonly type: "paused";
  readonly why: string;
}

/** The game continues from an earlier frame; `recording_id` is the abandoned version. */
interface Rewound {
  readonly type: "rewound";
  readonly frame: number;
  readonly hits: readonly HitAt[];
  readonly recording_id: number;
}

export interface Ended {
  readonly type: "ended";
  readonly reason: string | null;
  readonly frame: number;
  readonly hits: readonly HitAt[];
  readonly targets: number | null;
  readonly strays: number | null;
  readonly order_errors: number | null;
  readonly recording_id: number;
  readonly verification: "verified" | "failed";
  readonly verification_note: string;
}

interface TakenOver {
  readonly type: "taken_over";
}

/** Sent once a second, whatever else is. */
export interface Alive {
  readonly type: "alive";
}

export type ServerMessage =
  Hello | Countdown | HitMessage | Paused | Rewound | Ended | TakenOver | Alive;
export type Command = "ready" | "stop" | "pause" | "go_on" | "step" | "rewind" | "release";

/** Percent of the game's own rate, fastest first. */
export const SPEEDS = [100, 75, 50, 25] as const;

/** How long a server may be silent, so that the page says within 3 s that it is. */
export const SILENCE_MS = 2500;
/** The same of a new connection before its first message; a busy server takes its time. */
export const HANDSHAKE_MS = 5000;

/** Close codes of the server. */
export const CLOSE = {
  tryAgainLater: 1013,
  takenOver: 4001,
  badMessage: 4400,
  unauthorised: 4401,
  noSuchGame: 4404,
  gameOver: 4410,
} as const;
