import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import type { ReactNode } from "react";

import type { Behaviour, Run, RunResults } from "@/api/types";
import { Notice } from "@/components/feedback/States";
import { Attention } from "@/features/results/attention/Attention";
import { Curves } from "@/features/results/curves/Curves";
import { Comparison } from "@/features/results/games/Comparison";
import { PolicyResults } from "@/features/results/games/PolicyResults";
import { TeachMore } from "@/features/results/games/TeachMore";
import { Extrapolation } from "@/features/results/reward/Extrapolation";
import { RewardCheck } from "@/features/results/reward/RewardCheck";
import { Files } from "@/features/results/run/Files";
import { Parameters } from "@/features/results/run/Parameters";
import { TakeAway } from "@/features/results/run/TakeAway";
import { isActive } from "@/lib/runs";

import { Section } from "./Section";
import type { Watched } from "./watched";

interface RunSectionsProps {
  run: Run;
  results: RunResults;
  behaviour: Behaviour;
  onWatch: (watched: Watched) => void;
}

interface SectionPlan {
  readonly id: string;
  /** The question that it answers. */
  readonly title: string;
  /** Whether it is unfolded at first. */
  readonly open?: boolean;
  readonly body: ReactNode;
}

/** What else there is to say of a run, behind headings. */
export function RunSections(props: RunSectionsProps) {
  return (
    <div>
      {sectionsOf(props).map(({ id, title, open = false, body }) => (
        <Section key={id} id={id} title={title} open={open}>
          {body}
        </Section>
      ))}
    </div>
  );
}

/** Returns the sections that have content so far; curves come first while the run is active. */
function sectionsOf({
  run,
  results,
  behaviour,
  onWatch,
}: RunSectionsProps): readonly SectionPlan[] {
  const curves = {
    id: "curves",
    title: t`How did it learn?`,
    open: isActive(run),
    body: <Curves runId={run.id} active={isActive(run)} />,
  };
  const active = isActive(run);
  return [
    active ? curves : null,
    results.summaries.length > 0 && {
      id: "result",
      title: t`How well do imitator and clone play?`,
      body: <PolicyResults results={results} behaviour={behaviour} />,
    },
    results.comparison.length > 0 && {
      id: "games",
      title: t`How did each game go?`,
      body: <Comparison results={results} behaviour={behaviour} onWatch={onWatch} />,
    },
    (active
      ? results.training_games !== null
      : results.artifacts.some(({ kind }) => kind === "imitator")) && {
      id: "teach",
      title: active ? t`What teaches it more while it learns?` : t`What teaches it more?`,
      open: active,
      body: <TeachMore results={results} behaviour={behaviour} onWatch={onWatch} />,
    },
    results.check && {
      id: "check",
      title: t`Does the reward agree with the ranking?`,
      open: run.status === "stopped",
      body: (
        <>
          {run.recipe_values.method === "gail" && (
            <Notice tone="calm">
              <p>
                <Trans>
                  GAIL&rsquo;s imitator learned from its own discriminator, not from this reward,
                  which is shown for comparison.
                </Trans>
              </p>
            </Notice>
          )}
          <RewardCheck
            check={results.check}
            message={run.message}
            behaviour={behaviour}
            onWatch={onWatch}
          />
        </>
      ),
    },
    results.judged.some((group) => !group.demonstrated) && {
      id: "extrapolation",
      title: t`Does the reward agree with what games were worth?`,
      body: <Extrapolation judged={results.judged} />,
    },
    results.attention.length > 0 && {
      id: "attention",
      title: t`What does the reward look at?`,
      body: <Attention results={results} onWatch={onWatch} />,
    },
    active ? null : curves,
    run.status === "done" && {
      id: "archive",
      title: t`Take it with you`,
      open: true,
      body: <TakeAway run={run} behaviour={behaviour} />,
    },
    results.artifacts.length > 0 && {
      id: "files",
      title: t`Which files are there?`,
      body: <Files artifacts={results.artifacts} />,
    },
    { id: "parameters", title: t`How was it set up?`, body: <Parameters run={run} /> },
  ].filter((plan) => plan !== null && plan !== false);
}
