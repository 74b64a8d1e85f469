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
import { WatchLinks } from "@/features/results/run/WatchLinks";
import { isActive, runName } from "@/lib/runs";

import styles from "./RunPage.module.css";
import type { Watched } from "./watched";

/** A run: its progress while it is active, and its results. */
export function RunPage({ run, behaviour }: { run: Run; behaviour: Behaviour }) {
  const { data: results, error, refetch } = useQuery(resultsQuery(run.id));
  const [watched, setWatched] = useState<Watched | null>(null);
  return (
    <div className={styles.stack}>
      <PageTitle>{t`${runName(run)} · ${behaviour.name} · Tril`}</PageTitle>
      <RunHead run={run} />
      {results?.verdict && (
        <VerdictView
          verdict={results.verdict}
          run={run}
          behaviour={behaviour}
          canTeach={results.proposed.length > 0 || results.training_games !== null}
        />
      )}
      <RunNotices run={run} />
      {isActive(run) && <NotifySwitch />}
      {run.status !== "done" && <Stages run={run} />}
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
  readonly title: string;
  readonly body: ReactNode;
}

function Sections(props: SectionsProps) {
  const plans = sectionsOf(props);
  return (
    <>
      <Alarms results={props.results} />
      <WatchLinks results={props.results} />
      <nav className={styles.sections} aria-label={t`On this page`}>
        {plans.map(({ id, title }) => (
          <a key={id} href={`#${id}`}>
            {title}
          </a>
        ))}
      </nav>
      {plans.map(({ id, title, body }) => (
        <section key={id} id={id} className={styles.section} aria-labelledby={`${id}-title`}>
          <h2 id={`${id}-title`}>{title}</h2>
          {body}
        </section>
      ))}
    </>
  );
}

/** Returns the sections that have content so far; curves come first while the run is active. */
function sectionsOf({ run, results, behaviour, onWatch }: SectionsProps): readonly SectionPlan[] {
  const curves = {
    id: "curves",
    title: t`Curves`,
    body: <Curves runId={run.id} active={isActive(run)} />,
  };
  const active = isActive(run);
  return [
    active ? curves : null,
    results.summaries.length > 0 && {
      id: "result",
      title: t`Result`,
      body: <PolicyResults results={results} behaviour={behaviour} />,
    },
    results.comparison.length > 0 && {
      id: "games",
      title: t`The same game, played by each`,
      body: <Comparison results={results} behaviour={behaviour} onWatch={onWatch} />,
    },
    (active
      ? results.training_games !== null
      : results.artifacts.some(({ kind }) => kind === "imitator")) && {
      id: "teach",
      title: active ? t`Teach it while it learns` : t`Teach it more`,
      body: <TeachMore results={results} behaviour={behaviour} onWatch={onWatch} />,
    },
    results.check && {
      id: "check",
      title: t`Reward and ranking`,
      body: (
        <>
          {run.recipe_values.method === "gail" && (
            <Notice tone="calm">
              <p>
                <Trans>
                  The imitator of GAIL did not learn from this reward: its own discriminator
                  compares play with the perfect games. The reward and its check are shown to
                  compare with.
                </Trans>
              </p>
            </Notice>
          )}
          <RewardCheck check={results.check} behaviour={behaviour} onWatch={onWatch} />
        </>
      ),
    },
    results.judged.some((group) => !group.demonstrated) && {
      id: "extrapolation",
      title: t`Reward and what games were worth`,
      body: <Extrapolation judged={results.judged} />,
    },
    results.attention.length > 0 && {
      id: "attention",
      title: t`What the reward model looks at`,
      body: <Attention results={results} onWatch={onWatch} />,
    },
    active ? null : curves,
    run.status === "done"
      ? {
          id: "files",
          title: t`Take it away`,
          body: (
            <>
              <TakeAway run={run} behaviour={behaviour} />
              <Files artifacts={results.artifacts} />
            </>
          ),
        }
      : results.artifacts.length > 0 && {
          id: "files",
          title: t`Files`,
          body: <Files artifacts={results.artifacts} />,
        },
    { id: "parameters", title: t`Parameters`, body: <Parameters run={run} /> },
  ].filter((plan) => plan !== null && plan !== false);
}
