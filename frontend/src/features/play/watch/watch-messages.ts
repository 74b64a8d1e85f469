/** The messages of a page that watches (docs/protocol.md). */
import type { HitAt } from "@/features/play/stream/text-messages";
import type { Overlay } from "@/games/view";
import type { ScreenFormat } from "@/lib/game/screen";

interface WatchHello extends ScreenFormat {
  readonly type: "hello";
  readonly max_frames: number;
  /** The frame that the policies begin at, after an opening. */
  readonly frame: number;
  readonly speed_percent: number;
  readonly overlay: Overlay | null;
  readonly start: Readonly<Record<string, number>>;
  readonly start_number: number | null;
  readonly actors: readonly object[];
}

/** The action of a lane's next step, and the probability of each. */
export interface Decision {
  readonly type: "decision";
  readonly lane: number;
  readonly frame: number;
  readonly action: number;
  readonly probabilities: readonly number[];
}

interface LaneReward {
  readonly type: "reward";
  readonly lane: number;
  readonly frame: number;
  readonly level: number;
  /** Its standard deviation; null if the reward model does not know it. */
  readonly deviation: number | null;
}

/** What a network looks at in a lane's state; `shares` are 84x84 bytes, base64, 255 for `most`. */
export interface LaneAttention {
  readonly type: "attention";
  readonly lane: number;
  readonly frame: number;
  readonly most: number;
  /** The action that a policy would choose, whose logit the map explains; null of the reward. */
  readonly action: number | null;
  readonly shares: string;
}

interface LaneHit extends HitAt {
  readonly type: "hit";
  readonly lane: number;
}

export interface LaneEnded {
  readonly type: "ended";
  readonly lane: number;
  readonly reason: string;
  readonly frame: number;
  readonly hits: readonly HitAt[];
  readonly targets: number | null;
  readonly strays: number | null;
  readonly order_errors: number | null;
}

interface Paused {
  readonly type: "paused";
  readonly why: string;
}

/** The person's game that continues a lane's. */
export interface Taken {
  readonly type: "taken";
  readonly lane: number;
  readonly game_id: string;
  readonly behaviour_id: number;
}

interface Refused {
  readonly type: "refused";
  readonly why: string;
}

interface Bare {
  readonly type: "playing" | "waiting" | "finished" | "alive";
}

export type WatchMessage =
  | WatchHello
  | Decision
  | LaneReward
  | LaneAttention
  | LaneHit
  | LaneEnded
  | Paused
  | Taken
  | Refused
  | Bare;
