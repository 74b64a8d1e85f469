/** What a run's states and stages are called, and how long a run will take. */
import { duration, remaining } from "./format";

export type RunStatus =
  "queued" | "running" | "cancelling" | "cancelled" | "stopped" | "failed" | "done";

const ACTIVE: ReadonlySet<RunStatus> = new Set(["queued", "running", "cancelling"]);

/** Whether something may still happen by itself. */
export function isActive({ status }: { readonly status: RunStatus }): boolean {
  return ACTIVE.has(status);
}

export const STATUS_NAMES: Readonly<Record<RunStatus, string>> = {
  queued: "Waiting",
  running: "Running",
  cancelling: "Being cancelled",
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

/** A stage's name for people. */
export function stageName(stage: string): string {
  return STAGES[stage]?.name ?? stage;
}

/** One sentence on what happens in a stage. */
export function stageInWords(stage: string): string {
  return STAGES[stage]?.what ?? "";
}

/** "Run 3f2a9c": enough of the id to tell runs apart. */
export function runName({ id }: { readonly id: string }): string {
  return `Run ${id.slice(0, 6)}`;
}

interface Recipe {
  readonly steps_per_s: number;
  readonly overhead_s: number;
}

/** Seconds that a run of so many steps will take on this machine. */
export function estimateSeconds(recipe: Recipe, steps: number): number {
  return recipe.overhead_s + steps / recipe.steps_per_s;
}

/** "about 17 min". */
export function estimateInWords(recipe: Recipe, steps: number): string {
  return `about ${duration(estimateSeconds(recipe, steps))}`;
}

interface Going {
  readonly status: RunStatus;
  readonly stage: string;
  readonly progress: number;
  readonly remaining_s: number | null;
}

/** Where a run stands, in one line: "Imitator, 42 %, about 9 min left". */
export function standing(run: Going): string {
  if (run.status !== "running") return STATUS_NAMES[run.status];
  const parts = [stageName(run.stage), `${Math.floor(run.progress * 100)} %`];
  if (run.remaining_s !== null) parts.push(remaining(run.remaining_s));
  return parts.filter(Boolean).join(", ");
}
