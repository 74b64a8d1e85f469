import type { Ended, HitAt } from "./text-messages";

/**
 * What a game is doing, as its page sees it.
 *
 * - connecting: nothing was received yet
 * - countdown, playing, paused, ended: what the server reports
 * - stepping: paused and played frame by frame
 * - rewinding: running backwards
 * - lost: the connection broke and is being retried
 * - full: too many games are open; retried, too
 * - elsewhere: another tab has taken the game over
 * - gone: there is no such game any more
 * - refused: this browser is not signed in any more
 */
export type Phase =
  | "connecting"
  | "countdown"
  | "playing"
  | "paused"
  | "stepping"
  | "rewinding"
  | "ended"
  | "lost"
  | "full"
  | "elsewhere"
  | "gone"
  | "refused";

export interface GameState {
  readonly phase: Phase;
  /** Whole seconds left of the countdown. */
  readonly seconds: number;
  readonly hits: readonly HitAt[];
  /** Why the game is paused. */
  readonly why: string;
  readonly ended: Ended | null;
  /** When the game ended, by `performance.now()`. */
  readonly endedAt: number;
  /** Percent of the game's own rate. */
  readonly speed: number;
}
