/** The way from playing to looking: what of it is done, and what comes next. */
import { type Behaviour, type Run } from "@/api/types";
import { count, fixed } from "@/lib/format";
import { isActive } from "@/lib/runs";

export type StepId = "play" | "rank" | "train" | "look";

export interface PathStep {
  readonly id: StepId;
  readonly name: string;
  readonly done: boolean;
  readonly next: boolean;
  /** What there is so far. */
  readonly caption: string;
}

type Counts = Pick<Behaviour, "n_recordings" | "n_ranked" | "n_perfect" | "target">;
type RunFacts = Pick<Run, "status" | "progress" | "headline">;

/** The four steps; exactly one is next, unless all are done. */
export function pathOf(behaviour: Counts, runs: readonly RunFacts[]): readonly PathStep[] {
  const going = runs.find(isActive);
  const finished = runs.find((run) => run.status === "done");
  const steps = [
    {
      id: "play" as const,
      name: "Play",
      done: behaviour.n_recordings >= 2,
      caption: "good and bad games",
    },
    {
      id: "rank" as const,
      name: "Rank",
      done: behaviour.n_ranked >= 2 && behaviour.n_perfect >= 1,
      caption:
        behaviour.n_ranked === 0
          ? "best to worst"
          : `${behaviour.n_ranked} ranked, ${behaviour.n_perfect} perfect`,
    },
    {
      id: "train" as const,
      name: "Train",
      done: runs.length > 0,
      caption: going ? `${Math.floor(going.progress * 100)} % done` : "learn the reward",
    },
    {
      id: "look" as const,
      name: "Look",
      done: finished !== undefined,
      caption: lookCaption(behaviour, runs, finished),
    },
  ];
  const nextIndex = steps.findIndex((step) => !step.done);
  return steps.map((step, index) => ({ ...step, next: index === nextIndex }));
}

function lookCaption(
  behaviour: Counts,
  runs: readonly RunFacts[],
  finished: RunFacts | undefined,
): string {
  const targets = finished?.headline?.imitator?.targets;
  if (targets && behaviour.target) {
    return `${fixed(targets.mean, 1)} of ${behaviour.target.length} targets`;
  }
  return runs.length === 0 ? "what was learned" : count(runs.length, "run");
}
