import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { Measure, MeasureMean, MeasureRow } from "@/api/types";
import { ActorMark } from "@/components/game/ActorMark";
import { useGame } from "@/games/game";
import { meanValue, measureSentence } from "@/games/measures";
import { NONE } from "@/lib/format";

import styles from "./SummaryTable.module.css";

const PLAYERS = ["imitator", "clone", "person"] as const;

/** What the behaviour measures, over the games of imitator, clone and people. */
export function MeasureTable({ rows }: { rows: readonly MeasureRow[] }) {
  const game = useGame();
  if (rows.length === 0) return null;
  const players = PLAYERS.filter(
    (player) => player !== "person" || rows.some((row) => row.person !== null),
  );
  return (
    <table className={styles.table} aria-label={t`Measures of the behaviour`}>
      <thead>
        <tr>
          <td />
          {players.map((player) => (
            <th key={player} scope="col">
              <ActorMark actor={player} />
            </th>
          ))}
        </tr>
      </thead>
      <tbody>
        {rows.map((row, index) => (
          <tr key={index}>
            <th scope="row">{measureSentence(row.measure, game)}</th>
            {players.map((player) => (
              <Mean key={player} mean={row[player]} measure={row.measure} />
            ))}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

function Mean({ mean, measure }: { mean: MeasureMean | null; measure: Measure }) {
  if (!mean) return <td className={styles.value}>{NONE}</td>;
  return (
    <td className={styles.value}>
      <span className={styles.mean}>{meanValue(mean.mean, measure)}</span>
      {mean.n_met !== null && (
        <span className={styles.bounds}>
          <Trans>
            met in {mean.n_met} of {mean.n}
          </Trans>
        </span>
      )}
    </td>
  );
}
