/** What a recording is called and how it went, in words. */
import { type Cell } from "@/lib/game/aliens";

import { count, FRAMES_PER_STEP, seconds, STEPS_PER_S } from "./format";

/** Fields of a recording that these functions read. */
interface Played {
  readonly id: number;
  readonly end: string | null;
  readonly n_steps: number;
  readonly hits: readonly { readonly row: number; readonly column: number }[];
  readonly targets: number | null;
  readonly strays: number | null;
  readonly order_errors: number | null;
}

/** "Recording 12". */
export function recordingName({ id }: { readonly id: number }): string {
  return `Recording ${id}`;
}

/** The cells shot, in order of time. */
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

/** Why a game ended, in words. */
export function endInWords(end: string | null): string {
  if (end === null) return "not played to its end";
  return ENDS[end] ?? end.replaceAll("_", " ");
}

/** "5 of 6 targets, 1 stray", with order errors if there are any; null without a target. */
export function scoreInWords(recording: Played, nTargets: number | null): string {
  const { targets, strays, order_errors: errors } = recording;
  if (targets === null || strays === null) return count(recording.hits.length, "alien") + " hit";
  const of = nTargets === null ? "" : ` of ${nTargets}`;
  const parts = [`${targets}${of} targets`, strays === 0 ? "no strays" : count(strays, "stray")];
  if (errors) parts.push(`${count(errors, "hit")} out of order`);
  return parts.join(", ");
}

/** "survived all 300 steps, 20.0 s" or "139 steps, 9.3 s, hit by a bomb". */
export function courseInWords(recording: Pick<Played, "n_steps" | "end">): string {
  const { n_steps: steps, end } = recording;
  if (end === "steps") return `${endInWords(end)}, ${seconds(steps / STEPS_PER_S)}`;
  return `${lengthInWords(recording)}, ${endInWords(end)}`;
}

/** "300 steps, 20.0 s". */
export function lengthInWords({ n_steps }: Pick<Played, "n_steps">): string {
  return `${count(n_steps, "step")}, ${seconds(n_steps / STEPS_PER_S)}`;
}

/** The step in which a frame lies. */
export function stepOf(frame: number): number {
  return Math.floor(frame / FRAMES_PER_STEP);
}
