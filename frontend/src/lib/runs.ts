/** Names of a run's states and stages, and estimates of its duration. */
import { duration, remaining } from "./format";

type RunStatus = "queued" | "running" | "cancelling" | "cancelled" | "stopped" | "failed" | "done";

const ACTIVE: ReadonlySet<RunStatus> = new Set(["queued", "running", "cancelling"]);

/** Whether a run is queued, running or being cancelled. */
export function isActive({ status }: { readonly status: RunStatus }): boolean {
  return ACTIVE.has(status);
}

export const STATUS_NAMES: Readonly<Record<RunStatus, string>> = {
  queued: "Waiting",
  running: "Running",
  cancelling: "Cancelling",
  cancelled: "Cancelled",
  stopped: "Stopped by the check",
  failed: "Failed",
  done: "Done",
};

interface Stage {
  readonly name: string;
  readonly what: string;
}

const STAGES: Readonly<Record<string, Stage>> = {
  demonstrations: { name: "Demonstrations", what: "A scripted player makes the example games." },
  trajectories: { name: "Replay", what: "Each ranked recording is replayed as an agent sees it." },
  reward: { name: "Reward model", what: "A network learns what makes better games better." },
  check: { name: "Check", what: "Does the learned reward agree with the ranking?" },
  clone: { name: "Clone", what: "A baseline copies the perfect recordings." },
  imitator: { name: "Imitator", what: "An agent plays to earn the learned reward." },
  evaluation: { name: "Evaluation", what: "Both play from starts they were not trained on." },
  attention: { name: "Attention", what: "What on the screen does the reward model look at?" },
};

/** Returns the display name of a stage. */
export function stageName(stage: string): string {
  return STAGES[stage]?.name ?? stage;
}

/** Describes a stage in one sentence. */
export function describeStage(stage: string): string {
  return STAGES[stage]?.what ?? "";
}

/** Names a run by the beginning of its id: "Run 3f2a9c". */
export function runName({ id }: { readonly id: string }): string {
  return `Run ${id.slice(0, 6)}`;
}

interface Recipe {
  readonly steps_per_s: number;
  readonly overhead_s: number;
}

/** Estimates the duration of a run on this machine, in seconds. */
function estimateSeconds(recipe: Recipe, steps: number): number {
  return recipe.overhead_s + steps / recipe.steps_per_s;
}

/** Describes the estimated duration of a run: "about 17 min". */
export function describeEstimate(recipe: Recipe, steps: number): string {
  return `about ${duration(estimateSeconds(recipe, steps))}`;
}

interface RunProgress {
  readonly status: RunStatus;
  readonly stage: string;
  readonly progress: number;
  readonly remaining_s: number | null;
}

/** Summarizes the progress of a run: "Imitator, 42 %, about 9 min left". */
export function statusLine(run: RunProgress): string {
  if (run.status !== "running") return STATUS_NAMES[run.status];
  const parts = [stageName(run.stage), `${Math.floor(run.progress * 100)} %`];
  if (run.remaining_s !== null) parts.push(remaining(run.remaining_s));
  return parts.filter(Boolean).join(", ");
}
