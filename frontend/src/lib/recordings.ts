/** Describes recordings: their names, results and lengths. */
import { type Cell } from "@/lib/game/aliens";

import { count, FRAMES_PER_STEP, seconds, STEPS_PER_S } from "./format";

/** The fields of a recording that are read here. */
interface Played {
  readonly id: number;
  readonly end: string | null;
  readonly state: "playing" | "unfinished" | "finished" | "kept";
  readonly verification: "pending" | "verified" | "failed";
  readonly deleted: boolean;
  readonly n_steps: number;
  readonly hits: readonly { readonly row: number; readonly column: number }[];
  readonly targets: number | null;
  readonly strays: number | null;
  readonly order_errors: number | null;
}

export function recordingName({ id }: { readonly id: number }): string {
  return `Recording ${id}`;
}

/** Returns the cells hit, in order of time. */
export function hitCells(recording: Pick<Played, "hits">): readonly Cell[] {
  return recording.hits.map(({ row, column }) => [row, column] as const);
}

const ENDS: Readonly<Record<string, string>> = {
  hit: "hit by a bomb",
  lives: "hit by a bomb",
  landed: "the aliens landed",
  cleared: "all aliens gone",
  steps: "survived all 300 steps",
};

/** Describes why a game ended. */
export function describeEnd(end: string | null): string {
  if (end === null) return "ended early";
  return ENDS[end] ?? end.replaceAll("_", " ");
}

/** Describes the result of a game: "5 of 6 targets, 1 stray", or "3 aliens hit" without a target. */
export function describeScore(recording: Played, nTargets: number | null): string {
  const { targets, strays, order_errors: errors } = recording;
  if (targets === null || strays === null) return count(recording.hits.length, "alien") + " hit";
  const of = nTargets === null ? "" : ` of ${nTargets}`;
  const parts = [`${targets}${of} targets`, strays === 0 ? "no strays" : count(strays, "stray")];
  if (errors) parts.push(`${count(errors, "hit")} out of order`);
  return parts.join(", ");
}

/** Describes a game: "survived all 300 steps, 20.0 s" or "139 steps, 9.3 s, hit by a bomb". */
export function describeCourse(recording: Pick<Played, "n_steps" | "end" | "state">): string {
  const { n_steps: steps, end, state } = recording;
  if (state === "unfinished") return `${describeLength(recording)}, its page was left`;
  if (end === "steps") return `${describeEnd(end)}, ${seconds(steps / STEPS_PER_S)}`;
  return `${describeLength(recording)}, ${describeEnd(end)}`;
}

/** Describes the length of a game: "300 steps, 20.0 s". */
function describeLength({ n_steps }: Pick<Played, "n_steps">): string {
  return `${count(n_steps, "step")}, ${seconds(n_steps / STEPS_PER_S)}`;
}

const DEATHS: ReadonlySet<string | null> = new Set(["hit", "lives"]);

/** Says what a game lacks to be perfect: "it missed 2 targets"; empty if nothing. */
export function imperfections(
  { targets, strays, order_errors: errors, end }: Omit<Scored, "hits">,
  nTargets: number | null,
): readonly string[] {
  const missed = nTargets === null || targets === null ? 0 : nTargets - targets;
  return [
    ...(missed > 0 ? [`it missed ${count(missed, "target")}`] : []),
    ...(strays ? [`it hit ${count(strays, "stray")}`] : []),
    ...(errors ? [`${count(errors, "hit")} came out of order`] : []),
    ...(DEATHS.has(end) ? ["it ended with the cannon hit"] : []),
  ];
}

type Scored = Pick<Played, "targets" | "strays" | "order_errors" | "end" | "hits">;

type Rankable = Pick<Played, "state" | "verification" | "deleted">;

/** Whether a game ended and waits to be kept or discarded. */
export function isUndecided({ state, deleted }: Pick<Played, "state" | "deleted">): boolean {
  return state === "finished" && !deleted;
}

/** Says why a recording can't be ranked; null if it can. */
export function whyUnrankable({ state, verification, deleted }: Rankable): string | null {
  if (deleted) return "It was deleted.";
  if (verification === "failed") return "It can't be ranked: a replay doesn't reproduce it.";
  if (state === "finished") return "Keep it to rank it, or discard it.";
  if (state === "unfinished") {
    return "Unfinished: its page was left before the game ended. Keep it to rank it all the same.";
  }
  return verification === "pending" ? "It can be ranked once it is verified." : null;
}

/** Returns the step of a frame. */
export function stepOf(frame: number): number {
  return Math.floor(frame / FRAMES_PER_STEP);
}
