import { Trans } from "@lingui/react/macro";

import type { Behaviour, Interval, PolicySummary } from "@/api/types";
import { ActorMark } from "@/components/game/ActorMark";
import { useGame } from "@/games/game";
import { NONE } from "@/lib/format";

import { IntervalPlot } from "./IntervalPlot";
import { summaryRows } from "./summary-rows";
import styles from "./SummaryTable.module.css";

interface SummaryTableProps {
  imitator: PolicySummary | null;
  clone: PolicySummary | null;
  behaviour: Behaviour;
  label: string;
}

/** Imitator and clone side by side: means with 95% intervals, also on a common axis. */
export function SummaryTable({ imitator, clone, behaviour, label }: SummaryTableProps) {
  const { max_steps } = useGame();
  const rows = summaryRows(
    imitator,
    clone,
    behaviour.target?.length ?? null,
    behaviour.ordered,
    max_steps,
  );
  return (
    <table className={styles.table} aria-label={label}>
      <thead>
        <tr>
          <td />
          <th scope="col">
            <ActorMark actor="imitator" />
          </th>
          <th scope="col">
            <ActorMark actor="clone" />
          </th>
          <td className={styles.plot} />
        </tr>
      </thead>
      <tbody>
        {rows.map((row) => (
          <tr key={row.name}>
            <th scope="row">{row.name}</th>
            <Value interval={row.imitator} write={row.write} />
            <Value interval={row.clone} write={row.write} />
            <td className={styles.plot}>
              <IntervalPlot
                low={row.low}
                high={row.high}
                intervals={[
                  ...(row.imitator ? [{ actor: "imitator" as const, interval: row.imitator }] : []),
                  ...(row.clone ? [{ actor: "clone" as const, interval: row.clone }] : []),
                ]}
              />
            </td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

function Value({
  interval,
  write,
}: {
  interval: Interval | null;
  write: (value: number) => string;
}) {
  if (!interval) return <td className={styles.value}>{NONE}</td>;
  return (
    <td className={styles.value}>
      <span className={styles.mean}>{write(interval.mean)}</span>
      <span className={styles.bounds}>
        <Trans>
          {write(interval.low)} to {write(interval.high)}
        </Trans>
      </span>
    </td>
  );
}
