import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { type ReactNode, useState } from "react";

import { resultsQuery } from "@/api/runs";
import type { Behaviour, Recording, Run, RunResults } from "@/api/types";
import { Failed, Loading, Notice } from "@/components/feedback/States";
import { PageTitle } from "@/components/PageTitle";
import { WatchDialog } from "@/components/recording/WatchDialog";
import { Attention } from "@/features/results/attention/Attention";
import { Curves } from "@/features/results/curves/Curves";
import { AddToRanking } from "@/features/results/games/AddToRanking";
import { Comparison } from "@/features/results/games/Comparison";
import { PolicyResults } from "@/features/results/games/PolicyResults";
import { TeachMore } from "@/features/results/games/TeachMore";
import { RunHead } from "@/features/results/head/RunHead";
import { hasVerdictOverGames, ResultView } from "@/features/results/result/ResultView";
import { Extrapolation } from "@/features/results/reward/Extrapolation";
import { RewardCheck } from "@/features/results/reward/RewardCheck";
import { Alarms } from "@/features/results/run/Alarms";
import { Files } from "@/features/results/run/Files";
import { NotifySwitch } from "@/features/results/run/NotifySwitch";
import { Parameters } from "@/features/results/run/Parameters";
import { RunNotices } from "@/features/results/run/RunNotices";
import { Stages } from "@/features/results/run/Stages";
import { TakeAway } from "@/features/results/run/TakeAway";
import { VerdictView } from "@/features/results/run/VerdictView";
import { isActive, runName } from "@/lib/runs";

import styles from "./RunPage.module.css";
import { Section } from "./Section";
import type { Watched } from "./watched";

/** A run: its progress while it is active, and its results. */
export function RunPage({ run, behaviour }: { run: Run; behaviour: Behaviour }) {
  const { data: results, error, refetch } = useQuery(resultsQuery(run.id));
  const [watched, setWatched] = useState<Watched | null>(null);
  const isDone = run.status === "done";
  const result = results && <ResultView run={run} results={results} behaviour={behaviour} />;
  return (
    <div className={styles.stack}>
      <PageTitle>{t`${runName(run)} · ${behaviour.name} · Tril`}</PageTitle>
      <RunHead run={run} behaviour={behaviour} />
      {results?.verdict && !hasVerdictOverGames(run, results) && (
        <VerdictView verdict={results.verdict} run={run} results={results} behaviour={behaviour} />
      )}
      {isDone ? result : null}
      <RunNotices run={run} />
      {isActive(run) && <NotifySwitch />}
      {!isDone && <Stages run={run} />}
      {results && <Alarms results={results} />}
      {isDone ? null : result}
      {results ? (
        <Sections run={run} results={results} behaviour={behaviour} onWatch={setWatched} />
      ) : error ? (
        <Failed what={t`The results`} error={error} onRetry={() => void refetch()} />
      ) : (
        <Loading what={t`the results`} rows={2} height="12rem" />
      )}
      {watched && (
        <WatchDialog
          recording={watched.recording}
          title={watched.title}
          behaviour={behaviour}
          runId={results?.check ? run.id : undefined}
          startFrame={watched.frame}
          actions={
            isOfPolicy(watched.recording) && (
              <AddToRanking recording={watched.recording} behaviourId={behaviour.id} />
            )
          }
          onClose={() => setWatched(null)}
        />
      )}
    </div>
  );
}

/** Whether a recording is a run's evaluation game, not one of its demonstrations. */
function isOfPolicy({ source, run_id: runId }: Recording): boolean {
  return source === "policy" && runId !== null;
}

interface SectionsProps {
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

function Sections(props: SectionsProps) {
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
function sectionsOf({ run, results, behaviour, onWatch }: SectionsProps): readonly SectionPlan[] {
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
