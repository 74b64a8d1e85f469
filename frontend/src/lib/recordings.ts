/** Describes recordings: their names, results and lengths. */

import { plural, t } from "@lingui/core/macro";

import { type Cell } from "@/lib/game/aliens";

import { FRAME_RATE_HZ, FRAMES_PER_STEP, seconds } from "./format";

/** The fields of a recording that are read here. */
interface Played {
  readonly id: number;
  readonly end: string | null;
  readonly state: "playing" | "unfinished" | "finished" | "kept";
  readonly verification: "pending" | "verified" | "failed";
  readonly deleted: boolean;
  readonly n_frames: number;
  readonly n_steps: number;
  readonly hits: { readonly length: number };
  readonly targets: number | null;
  readonly strays: number | null;
  readonly order_errors: number | null;
}

export function recordingName({ id }: { readonly id: number }): string {
  return t`Recording ${id}`;
}

/** Returns the cells hit, in order of time. */
export function hitCells(recording: {
  readonly hits: readonly { readonly row: number; readonly column: number }[];
}): readonly Cell[] {
  return recording.hits.map(({ row, column }) => [row, column] as const);
}

const ends = (): Readonly<Record<string, string>> => ({
  hit: t`hit by a bomb`,
  lives: t`hit by a bomb`,
  landed: t`the aliens landed`,
  cleared: t`all aliens gone`,
  steps: t`survived all 300 steps`,
});

/** Describes why a game ended. */
export function describeEnd(end: string | null): string {
  if (end === null) return t`ended early`;
  return ends()[end] ?? end.replaceAll("_", " ");
}

/** Describes the result of a game: "5 of 6 targets, 1 stray", or "3 aliens hit" without a target. */
export function describeScore(recording: Played, nTargets: number | null): string {
  const { targets, strays, order_errors: errors } = recording;
  if (targets === null || strays === null)
    return plural(recording.hits.length, { one: "# alien hit", other: "# aliens hit" });
  const parts = [
    nTargets === null ? t`${targets} targets` : t`${targets} of ${nTargets} targets`,
    strays === 0 ? t`no strays` : plural(strays, { one: "# stray", other: "# strays" }),
  ];
  if (errors)
    parts.push(plural(errors, { one: "# hit out of order", other: "# hits out of order" }));
  return parts.join(", ");
}

type Course = Pick<Played, "n_frames" | "n_steps" | "end" | "state">;

/** Describes a game: "survived all 300 steps, 20.0 s" or "139 steps, 9.3 s, hit by a bomb". */
export function describeCourse(recording: Course): string {
  const { n_frames: frames, end, state } = recording;
  if (state === "unfinished") return t`${describeLength(recording)}, its page was left`;
  if (end === "steps") return `${describeEnd(end)}, ${seconds(frames / FRAME_RATE_HZ)}`;
  return `${describeLength(recording)}, ${describeEnd(end)}`;
}

/** Describes the length of a game: "300 steps, 20.0 s". */
function describeLength({ n_frames: frames, n_steps }: Course): string {
  return `${plural(n_steps, { one: "# step", other: "# steps" })}, ${seconds(frames / FRAME_RATE_HZ)}`;
}

const DEATHS: ReadonlySet<string | null> = new Set(["hit", "lives"]);

/** Whether a game ended with the cannon hit or the aliens landed. */
export function isLost(end: string | null): boolean {
  return DEATHS.has(end) || end === "landed";
}

/** Says what a game lacks to be perfect: "it missed 2 targets"; empty if nothing. */
export function imperfections(
  { targets, strays, order_errors: errors, end }: Omit<Scored, "hits">,
  nTargets: number | null,
): readonly string[] {
  const missed = nTargets === null || targets === null ? 0 : nTargets - targets;
  return [
    ...(missed > 0
      ? [plural(missed, { one: "it missed # target", other: "it missed # targets" })]
      : []),
    ...(strays ? [plural(strays, { one: "it hit # stray", other: "it hit # strays" })] : []),
    ...(errors
      ? [plural(errors, { one: "# hit came out of order", other: "# hits came out of order" })]
      : []),
    ...(DEATHS.has(end) ? [t`it ended with the cannon hit`] : []),
  ];
}

type Scored = Pick<Played, "targets" | "strays" | "order_errors" | "end" | "hits">;

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
export function stepOf(frame: number): number {
  return Math.floor(frame / FRAMES_PER_STEP);
}
