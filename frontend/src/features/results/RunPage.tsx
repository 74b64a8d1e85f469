import { useQuery } from "@tanstack/react-query";
import { type ReactNode, useMemo, useState } from "react";

import { resultsQuery } from "@/api/runs";
import { isAlive, systemQuery } from "@/api/system";
import type { Behaviour, PolicyGamesSummary, PolicySummary, Run, RunResults } from "@/api/types";
import { RunStatus } from "@/components/Badges";
import { Failed, Loading, Notice } from "@/components/feedback/States";
import { WatchDialog } from "@/components/recording/WatchDialog";
import { Attention } from "@/features/results/attention/Attention";
import { Curves } from "@/features/results/curves/Curves";
import { Comparison, type Watched } from "@/features/results/games/Comparison";
import { SummaryTable } from "@/features/results/games/SummaryTable";
import { Extrapolation } from "@/features/results/reward/Extrapolation";
import { Check } from "@/features/results/reward/RewardCheck";
import { Alarms } from "@/features/results/run/Alarms";
import { Files, Parameters } from "@/features/results/run/Files";
import { RunActions } from "@/features/results/run/RunActions";
import { Stages } from "@/features/results/run/Stages";
import { count, shortCount } from "@/lib/format";
import { isActive, runName } from "@/lib/runs";

import { Ago } from "./Ago";
import styles from "./RunPage.module.css";

/** One run: how far it is while it goes, and all that came of it. */
export function RunPage({ run, behaviour }: { run: Run; behaviour: Behaviour }) {
  const { data: results, error, refetch } = useQuery(resultsQuery(run.id));
  const [watched, setWatched] = useState<Watched | null>(null);
  return (
    <div className={styles.stack}>
      <title>{`${runName(run)} · ${behaviour.name} · Tril`}</title>
      <Head run={run} />
      <Remarks run={run} />
      {run.status !== "done" && <Stages run={run} />}
      {results ? (
        <Sections run={run} results={results} behaviour={behaviour} onWatch={setWatched} />
      ) : error ? (
        <Failed what="The results" error={error} onRetry={() => void refetch()} />
      ) : (
        <Loading what="the results" rows={2} height="12rem" />
      )}
      {watched && (
        <WatchDialog
          recording={watched.recording}
          title={watched.title}
          nTargets={behaviour.target?.length ?? null}
          runId={results?.check ? run.id : undefined}
          startFrame={watched.frame}
          onClose={() => setWatched(null)}
        />
      )}
    </div>
  );
}

function Head({ run }: { run: Run }) {
  return (
    <div className={styles.head}>
      <div>
        <div className={styles.title}>
          <h2>{runName(run)}</h2>
          <RunStatus run={run} />
        </div>
        <p className={styles.facts}>
          <span>{run.recipe} recipe</span>
          <span>{shortCount(run.steps)} steps</span>
          <span>training seed {run.training_seed}</span>
          {run.n_ranked !== null && <span>{count(run.n_ranked, "ranked recording")}</span>}
          <Ago time={run.created_at} />
        </p>
      </div>
      <RunActions run={run} />
    </div>
  );
}

function Remarks({ run }: { run: Run }) {
  const { data: system } = useQuery(systemQuery);
  const waiting = isActive(run) && !run.worker_alive && isAlive(system, "worker") === false;
  return (
    <>
      {run.example && (
        <Notice tone="calm" icon="eye">
          <p>
            This is an example: its demonstrations were made by a scripted player, not by a person.
          </p>
        </Notice>
      )}
      {waiting && (
        <Notice live>
          <p>
            The worker isn&rsquo;t running, so nothing happens to this run. Start it with{" "}
            <code>tril up</code>; the run then goes on where it was.
          </p>
        </Notice>
      )}
      {run.message && (
        <Notice tone={run.status === "failed" ? "bad" : "warn"} live>
          <p>{run.message}</p>
        </Notice>
      )}
    </>
  );
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
      <nav className={styles.sections} aria-label="On this page">
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

/** What there is to show so far; while a run goes, its curves come first. */
function sectionsOf({ run, results, behaviour, onWatch }: SectionsProps): readonly SectionPlan[] {
  const curves = {
    id: "curves",
    title: "Curves",
    body: <Curves runId={run.id} active={isActive(run)} />,
  };
  const active = isActive(run);
  return [
    active ? curves : null,
    results.summaries.length > 0 && {
      id: "result",
      title: "Result",
      body: <Result results={results} behaviour={behaviour} />,
    },
    results.comparison.length > 0 && {
      id: "games",
      title: "The same game, played by each",
      body: <Comparison results={results} behaviour={behaviour} onWatch={onWatch} />,
    },
    results.check && {
      id: "check",
      title: "Reward and ranking",
      body: <Check check={results.check} behaviour={behaviour} onWatch={onWatch} />,
    },
    results.judged.some((group) => !group.demonstrated) && {
      id: "extrapolation",
      title: "Reward and what games were worth",
      body: <Extrapolation judged={results.judged} />,
    },
    results.attention.length > 0 && {
      id: "attention",
      title: "What the reward model looks at",
      body: <AttentionSection results={results} onWatch={onWatch} />,
    },
    active ? null : curves,
    results.artifacts.length > 0 && {
      id: "files",
      title: "Files",
      body: <Files artifacts={results.artifacts} />,
    },
    { id: "parameters", title: "Parameters", body: <Parameters run={run} /> },
  ].filter((plan) => plan !== null && plan !== false);
}

type ActionSelection = PolicyGamesSummary["action_selection"];

/** Beside greedy, the headline's; runs of earlier versions have no sticky games. */
const OTHER_SELECTIONS = [
  {
    selection: "sampled",
    title: "With actions drawn by chance instead",
    note: "Each policy draws its action by the probabilities that it gives them.",
    label: "Imitator and clone, actions drawn by chance",
  },
  {
    selection: "sticky",
    title: "With sticky actions",
    note:
      "Each policy takes the action it thinks best, but at every frame there is a chance of 25 % " +
      "that the last frame’s action is executed again: a test of whether it can recover.",
    label: "Imitator and clone, with sticky actions",
  },
] as const;

function Result({ results, behaviour }: { results: RunResults; behaviour: Behaviour }) {
  const find = (policy: "imitator" | "clone", selection: ActionSelection): PolicySummary | null =>
    results.summaries.find((one) => one.policy === policy && one.action_selection === selection)
      ?.summary ?? null;
  const both = (selection: ActionSelection) => ({
    imitator: find("imitator", selection),
    clone: find("clone", selection),
  });
  const greedy = both("greedy");
  const n = greedy.imitator?.steps.n ?? greedy.clone?.steps.n ?? 0;
  return (
    <>
      <SummaryTable {...greedy} behaviour={behaviour} label="Imitator and clone" />
      <p className={styles.note}>
        Means of {count(n, "game")} from starts that no training or demonstration game began from,
        with 95 % bootstrap intervals. Each policy takes the action it thinks best.
      </p>
      {OTHER_SELECTIONS.map(({ selection, title, note, label }) => {
        const found = both(selection);
        return (
          (found.imitator ?? found.clone) && (
            <details key={selection} className={styles.choice}>
              <summary className={styles.note}>{title}</summary>
              <p className={styles.note}>{note}</p>
              <SummaryTable {...found} behaviour={behaviour} label={label} />
            </details>
          )
        );
      })}
    </>
  );
}

function AttentionSection({
  results,
  onWatch,
}: {
  results: RunResults;
  onWatch: (watched: Watched) => void;
}) {
  const recordings = useMemo(
    () => new Map(results.check?.returns.map(({ recording }) => [recording.id, recording])),
    [results],
  );
  return (
    <>
      <p className={styles.note}>
        Each spot of the screen is covered in turn; the more R changes by that, the brighter (or
        redder) the spot. Shown at four states of the ranked recordings, by how high R is there.
      </p>
      <Attention maps={results.attention} recordings={recordings} onWatch={onWatch} />
    </>
  );
}
