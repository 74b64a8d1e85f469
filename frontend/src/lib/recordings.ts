/** Describes recordings: their names, results and lengths. */
import { type Cell } from "@/lib/game/aliens";

import { count, FRAMES_PER_STEP, seconds, STEPS_PER_S } from "./format";

/** The fields of a recording that are read here. */
interface Played {
  readonly id: number;
  readonly end: string | null;
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
  stopped: "stopped early",
};

/** Describes why a game ended. */
export function describeEnd(end: string | null): string {
  if (end === null) return "not played to its end";
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
export function describeCourse(recording: Pick<Played, "n_steps" | "end">): string {
  const { n_steps: steps, end } = recording;
  if (end === "steps") return `${describeEnd(end)}, ${seconds(steps / STEPS_PER_S)}`;
  return `${describeLength(recording)}, ${describeEnd(end)}`;
}

/** Describes the length of a game: "300 steps, 20.0 s". */
function describeLength({ n_steps }: Pick<Played, "n_steps">): string {
  return `${count(n_steps, "step")}, ${seconds(n_steps / STEPS_PER_S)}`;
}

/** Returns the step of a frame. */
export function stepOf(frame: number): number {
  return Math.floor(frame / FRAMES_PER_STEP);
}
