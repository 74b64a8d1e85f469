/** The four steps from playing to looking at results, and how far a behaviour is. */

import { plural, t } from "@lingui/core/macro";

import { type Behaviour, type Run } from "@/api/types";
import { fixed, percentDone, wholeShare } from "@/lib/format";
import { isActive } from "@/lib/runs";

export type StepId = "play" | "rank" | "train" | "look";

export interface PathStep {
  readonly id: StepId;
  readonly name: string;
  readonly done: boolean;
  readonly next: boolean;
  /** A summary of what there is so far. */
  readonly caption: string;
}

type Counts = Pick<Behaviour, "n_recordings" | "n_ranked" | "n_perfect" | "target">;
type RunFacts = Pick<Run, "status" | "progress" | "headline">;

/** Says how far an active run is: "Training, 34%". */
export function trainingStatus({ status, progress }: Pick<Run, "status" | "progress">): string {
  return status === "queued" ? t`Waiting to train` : t`Training, ${percentDone(progress)}`;
}

/** Returns the four steps; the first that is not done is next. */
export function pathOf(behaviour: Counts, runs: readonly RunFacts[]): readonly PathStep[] {
  const active = runs.find(isActive);
  const finished = runs.find((run) => run.status === "done");
  const steps = [
    {
      id: "play" as const,
      name: t`Play`,
      // Games that were borrowed are played as well.
      done: Math.max(behaviour.n_recordings, behaviour.n_ranked) >= 2,
      caption: t`good and bad games`,
    },
    {
      id: "rank" as const,
      name: t`Rank`,
      done: behaviour.n_ranked >= 2,
      caption:
        behaviour.n_ranked === 0
          ? t`best to worst`
          : [t`${behaviour.n_ranked} ranked`, t`${behaviour.n_perfect} starred`].join(", "),
    },
    {
      id: "train" as const,
      name: t`Train`,
      done: finished !== undefined,
      caption: active ? trainingStatus(active) : t`learn the reward`,
    },
    {
      id: "look" as const,
      name: t`Look`,
      done: finished !== undefined,
      caption: lookCaption(behaviour, runs, finished),
    },
  ];
  const nextIndex = steps.findIndex((step) => !step.done);
  return steps.map((step, index) => ({
    ...step,
    // What is under way needs nobody to begin it.
    next: index === nextIndex && !(step.id === "train" && active),
  }));
}

function lookCaption(
  behaviour: Counts,
  runs: readonly RunFacts[],
  finished: RunFacts | undefined,
): string {
  const targets = finished?.headline?.imitator?.targets;
  if (targets && behaviour.target) {
    return t`${fixed(targets.mean, 1)} of ${behaviour.target.length} targets`;
  }
  const understood = finished?.headline?.understood?.imitator;
  if (understood && !behaviour.target) {
    return t`imitator: ${wholeShare(understood.mean)}`;
  }
  return runs.length === 0
    ? t`what was learned`
    : plural(runs.length, { one: "# run", other: "# runs" });
}
