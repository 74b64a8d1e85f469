import type { Behaviour, ComparisonRow, Recording, RunResults } from "@/api/types";
import { AlienGrid } from "@/components/game/AlienGrid";
import { ThingMark } from "@/components/game/ThingMark";
import type { Watched } from "@/features/results/watched";
import { count, NONE } from "@/lib/format";
import { describeEnd, hitCells } from "@/lib/recordings";
import { playedBy, type Thing, THING_NAMES } from "@/lib/things";

import { AddToRanking } from "./AddToRanking";
import styles from "./Comparison.module.css";

interface ComparisonProps {
  results: RunResults;
  behaviour: Behaviour;
  onWatch: (watched: Watched) => void;
}

/** Compares the games of imitator, clone and best demonstration, start by start. */
export function Comparison({ results, behaviour, onWatch }: ComparisonProps) {
  const { comparison, further_comparison: further, best_demonstration: best } = results;
  const shared = { behaviour, best, onWatch };
  return (
    <>
      {behaviour.target && (
        <p className={styles.legend}>
          <span>
            <Sign kind="missing" /> target alien left
          </span>
          <span>
            <Sign kind="hit" /> target hit
          </span>
          <span>
            <Sign kind="stray" /> stray hit
          </span>
        </p>
      )}
      <StartsTable rows={comparison} label="Games from the first starts" {...shared} />
      {further.length > 0 && (
        <details className={styles.more}>
          <summary>{count(further.length, "further start")}</summary>
          <StartsTable rows={further} label="Games from further starts" {...shared} />
        </details>
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
  best: Recording | null;
  onWatch: (watched: Watched) => void;
}

function StartsTable({ rows, label, behaviour, best, onWatch }: StartsTableProps) {
  return (
    <table className={styles.table} aria-label={label}>
      <thead>
        <tr>
          <th scope="col">Start</th>
          <th scope="col">
            <ThingMark thing="imitator" />
          </th>
          <th scope="col">
            <ThingMark thing="clone" />
          </th>
          {best && (
            <th scope="col">
              <ThingMark thing={playedBy(best.source)}>Best demonstration</ThingMark>
            </th>
          )}
          <th scope="col">Winner</th>
        </tr>
      </thead>
      <tbody>
        {rows.map((row) => {
          const from = `from start ${row.start_number}`;
          const cells = { behaviour, from, onWatch };
          return (
            <tr key={row.start_number}>
              <th scope="row" className={styles.start}>
                Start {row.start_number}
                {!row.held_out && <small>seen in training</small>}
              </th>
              <td>
                <GameCell thing="imitator" recording={row.imitator?.recording} {...cells} />
              </td>
              <td>
                <GameCell thing="clone" recording={row.clone?.recording} {...cells} />
              </td>
              {best && (
                <td>
                  <GameCell
                    thing={playedBy(best.source)}
                    name="Best demonstration"
                    recording={best}
                    {...cells}
                    from=""
                  />
                </td>
              )}
              <td className={styles.winner}>
                <span className={styles.only}>Winner</span>
                <Winner winner={row.winner} />
              </td>
            </tr>
          );
        })}
      </tbody>
    </table>
  );
}

function Winner({ winner }: { winner: ComparisonRow["winner"] }) {
  if (winner === null) return <>{NONE}</>;
  return winner === "tie" ? <>Tie</> : <ThingMark thing={winner} />;
}

function GameCell({
  thing,
  name = THING_NAMES[thing],
  recording,
  behaviour,
  from,
  onWatch,
}: {
  thing: Thing;
  name?: string;
  recording: Recording | undefined;
  behaviour: Behaviour;
  from: string;
  onWatch: (watched: Watched) => void;
}) {
  if (!recording) return <>{NONE}</>;
  const title = `${name} ${from}`.trim();
  return (
    <>
      <button
        type="button"
        className={styles.game}
        aria-label={`Watch ${title.charAt(0).toLowerCase()}${title.slice(1)}`}
        onClick={() => onWatch({ recording, title })}
      >
        <span className={styles.only}>
          <ThingMark thing={thing}>{name === "Best demonstration" ? "Best" : name}</ThingMark>
        </span>
        <AlienGrid hits={hitCells(recording)} target={behaviour.target} scale={2} />
        <span className={styles.words}>
          <Outcome recording={recording} />
          <span>{describeEnd(recording.end)}</span>
        </span>
      </button>
      {name !== "Best demonstration" && (
        <AddToRanking recording={recording} behaviourId={behaviour.id} kind="quiet" />
      )}
    </>
  );
}

function Outcome({ recording }: { recording: Recording }) {
  const { targets, strays, hits } = recording;
  if (targets === null || strays === null) return <b>{count(hits.length, "alien")}</b>;
  return (
    <span>
      <b>{count(targets, "target")}</b>, {strays === 0 ? "no strays" : count(strays, "stray")}
    </span>
  );
}
