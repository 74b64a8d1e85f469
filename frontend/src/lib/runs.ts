/** Names of a run's states, its current stage, estimates of its duration, and the run to continue. */

import { t } from "@lingui/core/macro";

import { duration, percentDone, remaining } from "./format";

type RunStatus = "queued" | "running" | "cancelling" | "cancelled" | "stopped" | "failed" | "done";

const ACTIVE: ReadonlySet<RunStatus> = new Set(["queued", "running", "cancelling"]);

/** Whether a run is queued, running or being cancelled. */
export function isActive({ status }: { readonly status: RunStatus }): boolean {
  return ACTIVE.has(status);
}

export const statusNames = (): Readonly<Record<RunStatus, string>> => ({
  queued: t`Waiting`,
  running: t`Running`,
  cancelling: t`Cancelling`,
  cancelled: t`Cancelled`,
  stopped: t`Stopped by the check`,
  failed: t`Failed`,
  done: t`Done`,
});

interface Stage {
  readonly name: string;
  readonly label: string;
  readonly summary: string;
}

/** Returns the current stage of a run; undefined before its first one. */
export function currentStage<S extends Stage>(run: {
  readonly stage: string;
  readonly stages: readonly S[];
}): S | undefined {
  return run.stages.find(({ name }) => name === run.stage);
}

/** A run's own name, or else the beginning of its id: "Run 3f2a9c". */
export function runName({
  id,
  name = "",
}: {
  readonly id: string;
  readonly name?: string;
}): string {
  return name === "" ? shortId(id) : name;
}

/** Names a run by the beginning of its id, whatever a person calls it: "Run 3f2a9c". */
export function shortId(id: string): string {
  return t`Run ${id.slice(0, 6)}`;
}

interface Recipe {
  readonly steps_per_s: number;
  readonly overhead_s: number;
}

/** Estimates the duration of a run on this machine, in seconds. */
function estimateSeconds(recipe: Recipe, steps: number): number {
  return recipe.overhead_s + steps / recipe.steps_per_s;
}

interface Proposal {
  readonly default_steps: number;
  readonly ordered_steps: number;
}

/** Returns how many steps a recipe proposes for a behaviour. */
export function proposedSteps(
  recipe: Proposal,
  { ordered }: { readonly ordered: boolean },
): number {
  return ordered ? recipe.ordered_steps : recipe.default_steps;
}

/** Describes the estimated duration of a run: "about 17 min". */
export function describeEstimate(recipe: Recipe, steps: number): string {
  return t`about ${duration(estimateSeconds(recipe, steps))}`;
}

interface RunProgress {
  readonly status: RunStatus;
  readonly stage: string;
  readonly stages: readonly Stage[];
  readonly progress: number;
  readonly remaining_s: number | null;
  readonly queue_position: number | null;
}

/** Names a place among the waiting runs: "next in the queue". */
export function queuePlace(position: number): string {
  return position === 1 ? t`next in the queue` : t`number ${position} in the queue`;
}

/** Summarizes the progress of a run: "Imitator, 42%, about 9 min left". */
export function statusLine(run: RunProgress): string {
  if (run.queue_position !== null) {
    return `${statusNames().queued}, ${queuePlace(run.queue_position)}`;
  }
  if (run.status !== "running") return statusNames()[run.status];
  const parts = [currentStage(run)?.label, percentDone(run.progress)];
  if (run.remaining_s !== null) parts.push(remaining(run.remaining_s));
  return parts.filter(Boolean).join(", ");
}

/** How the addresses of the pages up to a run's start name the run that it continues. */
const CONTINUING = ["continue", "steps"] as const;

/** Returns what a page's address says of the run to continue, to lead on with. */
export function continuing(search: URLSearchParams): URLSearchParams {
  const kept = new URLSearchParams();
  if (!search.has("continue")) return kept;
  for (const name of CONTINUING) {
    const value = search.get(name);
    if (value !== null) kept.set(name, value);
  }
  return kept;
}

/** Returns the address of a page with parameters, without a question mark if there are none. */
export function withSearch(path: string, search: URLSearchParams): string {
  return search.size === 0 ? path : `${path}?${search.toString()}`;
}
