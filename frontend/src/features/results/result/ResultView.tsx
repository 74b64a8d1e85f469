import { t } from "@lingui/core/macro";

import type { Behaviour, Run, RunResults } from "@/api/types";
import { BlindCard } from "@/features/results/blind/BlindCard";
import { WatchLinks } from "@/features/results/run/WatchLinks";

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

/** A run in one look: what was understood, what the imitator plays beside the person, and figures. */
export function ResultView({ run, results, behaviour }: ResultViewProps) {
  const games = shownGames(results);
  const { check } = results;
  const understood = check && check.statements.length > 0 && <Statements run={run} check={check} />;
  if (!games)
    return (
      <>
        {understood}
        <WatchLinks results={results} />
      </>
    );
  return (
    <section className={styles.result} aria-label={t`Result`}>
      {understood && <div className={styles.understood}>{understood}</div>}
      <div className={styles.games}>
        {/* Other games are another player. */}
        <GamesInStep
          key={`${games.imitator.recording.id} ${games.best?.id ?? ""}`}
          run={run}
          behaviour={behaviour}
          {...games}
        />
      </div>
      <div className={styles.figures}>
        <Figures results={results} behaviour={behaviour} />
        <BlindCard runId={run.id} />
        <WatchLinks results={results} />
      </div>
    </section>
  );
}
