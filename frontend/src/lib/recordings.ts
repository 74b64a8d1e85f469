/** Describes recordings: their names, and whether they can be ranked. */

import { t } from "@lingui/core/macro";

import { shortId } from "./runs";

/** The fields of a recording that are read here. */
interface Played {
  readonly id: number;
  readonly state: "playing" | "unfinished" | "finished" | "kept";
  readonly verification: "pending" | "verified" | "failed";
  readonly deleted: boolean;
  readonly n_steps: number;
}

/** What names a recording. */
export interface Named {
  readonly number: number | null;
  readonly borrowed: boolean;
  readonly run_id: string | null;
  readonly behaviour_name: string | null;
}

/**
 * Names a recording by its number, which its behaviour or its run has once; a borrowed one by where
 * it is from, too. One that is not fetched yet has no number.
 */
export function recordingName(recording: Named | undefined): string {
  if (!recording) return t`Recording`;
  const { number, borrowed, run_id: runId, behaviour_name: behaviour } = recording;
  if (number === null) return numberedName(null);
  if (borrowed && runId !== null) return t`Recording ${number} of ${shortId(runId)}`;
  if (borrowed && behaviour !== null) return t`Recording ${number} of ${behaviour}`;
  return numberedName(number);
}

/** Names a recording of the behaviour at hand by its number, which it has from its end on. */
export function numberedName(number: number | null): string {
  return number === null ? t`New recording` : t`Recording ${number}`;
}

type Rankable = Pick<Played, "state" | "verification" | "deleted" | "n_steps">;

/** Whether a game ended and waits to be kept or discarded. */
export function isUndecided({ state, deleted }: Pick<Played, "state" | "deleted">): boolean {
  return state === "finished" && !deleted;
}

/** Whether a game that waits to be kept ended before its first step, so that there is nothing to keep. */
export function isEmpty({ state, n_steps: steps }: Pick<Played, "state" | "n_steps">): boolean {
  return steps === 0 && (state === "finished" || state === "unfinished");
}

/** Says why a recording can't be ranked; null if it can. */
export function whyUnrankable(recording: Rankable): string | null {
  const { state, verification, deleted } = recording;
  if (deleted) return t`It was deleted.`;
  if (isEmpty(recording)) return t`Nothing was played, so there is nothing to keep.`;
  if (verification === "failed") return t`It can’t be ranked: a replay doesn’t reproduce it.`;
  if (state === "finished") return t`Keep it to rank it, or discard it.`;
  if (state === "unfinished") {
    return t`Unfinished: its page was left before the game ended. Keep it to rank it all the same.`;
  }
  return verification === "pending" ? t`It can be ranked once it is verified.` : null;
}

/** Returns the step of a frame, from 0 on: that of the state which the agent sees. */
export function stepOf(
  frame: number,
  { frames_per_step: length }: { readonly frames_per_step: number },
): number {
  return Math.floor(frame / length);
}
