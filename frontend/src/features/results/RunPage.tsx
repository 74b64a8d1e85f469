import { t } from "@lingui/core/macro";
import { queryOptions, useQuery } from "@tanstack/react-query";
import { useState } from "react";

import { resultsQuery } from "@/api/runs";
import type { Behaviour, Recording, Run } from "@/api/types";
import { Failed, Loading } from "@/components/feedback/States";
import { PageTitle } from "@/components/PageTitle";
import { WatchDialog } from "@/components/recording/WatchDialog";
import { AddToRanking } from "@/features/results/games/AddToRanking";
import { RunHead } from "@/features/results/head/RunHead";
import { hasVerdictOverGames, ResultView } from "@/features/results/result/ResultView";
import { Alarms } from "@/features/results/run/Alarms";
import { NotifySwitch } from "@/features/results/run/NotifySwitch";
import { RunNotices } from "@/features/results/run/RunNotices";
import { Stages } from "@/features/results/run/Stages";
import { VerdictView } from "@/features/results/run/VerdictView";
import { onDemand } from "@/lib/on-demand";
import { isActive, runName } from "@/lib/runs";

import styles from "./RunPage.module.css";
import type { Watched } from "./watched";

const RunSections = onDemand(async () => (await import("./RunSections")).RunSections);
/** Its code, which is loaded beside the page, not before it. */
const sectionsQuery = queryOptions({
  queryKey: ["code", "run sections"],
  queryFn: RunSections.load,
  staleTime: Infinity,
});

/** A run: its progress while it is active, and its results. */
export function RunPage({ run, behaviour }: { run: Run; behaviour: Behaviour }) {
  const { data: results, error, refetch } = useQuery(resultsQuery(run.id));
  const [watched, setWatched] = useState<Watched | null>(null);
  const isDone = run.status === "done";
  const sections = useQuery(sectionsQuery);
  const loading = <Loading what={t`the results`} rows={2} height="12rem" />;
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
        sections.data ? (
          <RunSections run={run} results={results} behaviour={behaviour} onWatch={setWatched} />
        ) : sections.error ? (
          <Failed
            what={t`The details of the run`}
            error={sections.error}
            onRetry={() => void sections.refetch()}
          />
        ) : (
          loading
        )
      ) : error ? (
        <Failed what={t`The results`} error={error} onRetry={() => void refetch()} />
      ) : (
        loading
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
