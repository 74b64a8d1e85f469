import { t } from "@lingui/core/macro";

import type { Behaviour, Run, RunResults } from "@/api/types";
import { BlindCard } from "@/features/results/blind/BlindCard";
import {
  NextStep,
  toneOf,
  VerdictDetails,
  VerdictSentence,
} from "@/features/results/run/VerdictView";
import { WatchLinks } from "@/features/results/run/WatchLinks";
import { classes } from "@/lib/classes";

import { Figures } from "./Figures";
import { GamesInStep } from "./GamesInStep";
import styles from "./ResultView.module.css";
import { shownGames } from "./shown-games";
import { Statements } from "./Statements";

interface ResultViewProps {
  run: Run;
  results: RunResults;
  behaviour: Behaviour;
}

/**
 * A run in one look: the verdict in a sentence over what the imitator plays beside the person, then
 * what was understood, and figures.
 */
export function ResultView({ run, results, behaviour }: ResultViewProps) {
  const games = shownGames(results);
  const { check } = results;
  const verdict = hasVerdictOverGames(run, results) ? results.verdict : null;
  const understood = check && check.statements.length > 0 && <Statements run={run} check={check} />;
  if (!games)
    return (
      <>
        {understood}
        <WatchLinks results={results} />
      </>
    );
  return (
    <section
      className={classes(styles.result, verdict && styles.judged, verdict && toneOf(verdict))}
      aria-label={t`Result`}
    >
      {verdict && (
        <section className={styles.verdict} aria-label={t`Verdict`}>
          <VerdictSentence verdict={verdict} />
        </section>
      )}
      {verdict && (
        <section className={styles.further} aria-label={t`What to do next`}>
          <VerdictDetails verdict={verdict} />
          <NextStep verdict={verdict} run={run} results={results} behaviour={behaviour} />
        </section>
      )}
      <div className={styles.games}>
        {/* Other games are another player. */}
        <GamesInStep
          key={`${games.imitator.recording.id} ${games.best?.id ?? ""}`}
          run={run}
          behaviour={behaviour}
          {...games}
        />
      </div>
      {understood && <div className={styles.understood}>{understood}</div>}
      <div className={styles.figures}>
        <Figures results={results} behaviour={behaviour} />
        <BlindCard runId={run.id} />
        <WatchLinks results={results} />
      </div>
    </section>
  );
}

/** Whether the verdict stands over a finished run's games, with what else it says below them. */
export function hasVerdictOverGames(run: Run, results: RunResults): boolean {
  return run.status === "done" && results.verdict !== null && shownGames(results) !== null;
}
