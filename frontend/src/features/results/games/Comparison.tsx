import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { Behaviour, ComparisonRow, Recording, RunResults } from "@/api/types";
import { ItemGrid } from "@/components/game/ItemGrid";
import { ActorMark } from "@/components/game/ActorMark";
import { GamePicture, LOOPS } from "@/components/recording/GamePicture";
import type { Watched } from "@/features/results/watched";
import { useGame } from "@/games/game";
import { describeEnd, describeResult } from "@/games/outcomes";
import { useMedia } from "@/lib/browser/use-media";
import { inSentence, NONE } from "@/lib/format";
import { strayWords, takenCells } from "@/lib/game/items";
import { playedBy, type Actor, actorNames } from "@/lib/actors";

import { AddToRanking } from "./AddToRanking";
import styles from "./Comparison.module.css";

/** A phone, where each start is a card: see Comparison.module.css. */
const NARROW = "(max-width: 48rem)";

interface ComparisonProps {
  results: RunResults;
  behaviour: Behaviour;
  onWatch: (watched: Watched) => void;
}

/** Compares the games of imitator and clone, start by start, below the best demonstration. */
export function Comparison({ results, behaviour, onWatch }: ComparisonProps) {
  const { comparison, further_comparison: further, best_demonstration: best } = results;
  const narrow = useMedia(NARROW);
  // Without targets, nothing decides between two games.
  const decided = [...comparison, ...further].some(({ winner }) => winner !== null);
  const shared = { behaviour, decided, onWatch };
  const starts = comparison.length + further.length;
  const first = (
    <StartsTable rows={comparison} label={t`Games from the first starts`} {...shared} />
  );
  const others = further.length > 0 && (
    <StartsTable rows={further} label={t`Games from further starts`} {...shared} />
  );
  return (
    <>
      {behaviour.target && (
        <p className={styles.legend}>
          <span>
            <Trans>
              <Sign kind="missing" /> target left
            </Trans>
          </span>
          <span>
            <Trans>
              <Sign kind="hit" /> target hit
            </Trans>
          </span>
          <span>
            <Trans>
              <Sign kind="stray" /> stray hit
            </Trans>
          </span>
        </p>
      )}
      {best && (
        <div className={styles.best}>
          <p>
            <Trans>For comparison: the best demonstration, one game from a start of its own.</Trans>
          </p>
          <GameCell
            actor={playedBy(best.source)}
            best
            recording={best}
            from=""
            behaviour={behaviour}
            onWatch={onWatch}
          />
        </div>
      )}
      {narrow ? (
        <details className={styles.more}>
          <summary>
            {plural(starts, { one: "Games from # start", other: "Games from # starts" })}
          </summary>
          {first}
          {others}
        </details>
      ) : (
        <>
          {first}
          {others && (
            <details className={styles.more}>
              <summary>
                {plural(further.length, { one: "# further start", other: "# further starts" })}
              </summary>
              {others}
            </details>
          )}
        </>
      )}
    </>
  );
}

/** A sign of the grids, for the legend. */
function Sign({ kind }: { kind: "missing" | "hit" | "stray" }) {
  const paths = {
    missing: "M4 1h2v1H4zM3 2h4v1H3zM2 3h6v1H2zM1 4h8v2H1zM3 6h1v1H3zM6 6h1v1H6z",
    hit: "M3 3h4v4H3z",
    stray: "M3 3l4 4M7 3l-4 4",
  } as const;
  const colour = kind === "stray" ? "var(--bad)" : "var(--accent)";
  return (
    <svg viewBox="0 0 10 10" width="12" height="12" aria-hidden="true">
      {kind !== "stray" && <path d="M0 0h10v10H0z" fill="var(--accent-wash)" />}
      <path d={paths[kind]} {...(kind === "stray" ? { stroke: colour } : { fill: colour })} />
    </svg>
  );
}

interface StartsTableProps {
  rows: readonly ComparisonRow[];
  label: string;
  behaviour: Behaviour;
  /** Whether any game is known to be better than another, and so has a column. */
  decided: boolean;
  onWatch: (watched: Watched) => void;
}

function StartsTable({ rows, label, behaviour, decided, onWatch }: StartsTableProps) {
  return (
    <table className={styles.table} aria-label={label}>
      <thead>
        <tr>
          <th scope="col">
            <Trans>Start</Trans>
          </th>
          <th scope="col">
            <ActorMark actor="imitator" />
          </th>
          <th scope="col">
            <ActorMark actor="clone" />
          </th>
          {decided && (
            <th scope="col">
              <Trans>Imitator against clone</Trans>
            </th>
          )}
        </tr>
      </thead>
      <tbody>
        {rows.map((row) => {
          const from = t`from start ${row.start_number}`;
          const cells = { behaviour, from, onWatch };
          return (
            <tr key={row.start_number}>
              <th scope="row" className={styles.start}>
                <Trans>Start {row.start_number}</Trans>
                {!row.held_out && (
                  <small>
                    <Trans>seen in training</Trans>
                  </small>
                )}
              </th>
              <td>
                <GameCell actor="imitator" recording={row.imitator?.recording} {...cells} />
              </td>
              <td>
                <GameCell actor="clone" recording={row.clone?.recording} {...cells} />
              </td>
              {decided && (
                <td className={styles.winner}>
                  <span className={styles.only}>
                    <Trans>Imitator against clone</Trans>
                  </span>
                  <Winner winner={row.winner} />
                </td>
              )}
            </tr>
          );
        })}
      </tbody>
    </table>
  );
}

function Winner({ winner }: { winner: ComparisonRow["winner"] }) {
  if (winner === null) return <>{NONE}</>;
  return winner === "tie" ? (
    <>
      <Trans>Tie</Trans>
    </>
  ) : (
    <ActorMark actor={winner} />
  );
}

function GameCell({
  actor,
  best = false,
  recording,
  behaviour,
  from,
  onWatch,
}: {
  actor: Actor;
  /** Whether it is the best demonstration. */
  best?: boolean;
  recording: Recording | undefined;
  behaviour: Behaviour;
  from: string;
  onWatch: (watched: Watched) => void;
}) {
  const game = useGame();
  if (!recording) return <>{NONE}</>;
  const name = best ? t`Best demonstration` : actorNames()[actor];
  const title = `${name} ${from}`.trim();
  return (
    <>
      <button
        type="button"
        className={styles.game}
        onClick={() => onWatch({ recording, title })}
        {...LOOPS}
      >
        <span className="visually-hidden">{t`Watch ${inSentence(title)}`}</span>
        <span className={best ? undefined : styles.only}>
          <ActorMark actor={actor}>{name}</ActorMark>
        </span>
        <span className={styles.pictures}>
          <ItemGrid hits={takenCells(recording)} target={behaviour.target} scale={2} />
          <GamePicture recording={recording} />
        </span>
        <span className={styles.words}>
          <Outcome recording={recording} behaviour={behaviour} />
          <span>{describeEnd(recording.end, game)}</span>
        </span>
      </button>
      {!best && <AddToRanking recording={recording} behaviourId={behaviour.id} kind="quiet" />}
    </>
  );
}

function Outcome({ recording, behaviour }: { recording: Recording; behaviour: Behaviour }) {
  const game = useGame();
  const { targets, strays } = recording;
  if (targets === null || strays === null) {
    const result = describeResult(recording, behaviour, game);
    return result && <b>{result}</b>;
  }
  return (
    <span>
      <b>{plural(targets, { one: "# target", other: "# targets" })}</b>, {strayWords(strays)}
    </span>
  );
}
