import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { Link } from "react-router";

import type { Behaviour, RankingCheck, Run, RunResults } from "@/api/types";
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
  const understood = check && check.statements.length > 0 && (
    <Understood check={check} behaviour={behaviour} />
  );
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

function Understood({ check, behaviour }: { check: RankingCheck; behaviour: Behaviour }) {
  return (
    <div className={styles.question}>
      <Statements statements={check.statements} answers={check.answers} />
      <p>
        <Trans>
          Is this what you meant?{" "}
          <Link to={`/behaviours/${behaviour.id}/rank`}>Say so under Rank</Link>, and the next run
          knows.
        </Trans>
      </p>
    </div>
  );
}
