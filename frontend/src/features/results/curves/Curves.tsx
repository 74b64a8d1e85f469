import { useQuery } from "@tanstack/react-query";
import { useMemo } from "react";

import { Failed, Loading } from "@/components/feedback/States";

import { Chart } from "./Chart";
import { curveGroups } from "./curve-groups";
import styles from "./Curves.module.css";
import { useMetricsQuery } from "./metrics";

/** The training curves of a run, updated live. */
export function Curves({ runId, active }: { runId: string; active: boolean }) {
  const { data, error, refetch } = useQuery(useMetricsQuery(runId));
  const groups = useMemo(() => (data ? curveGroups(data.series) : []), [data]);
  if (error && !data) {
    return <Failed what="The curves" error={error} onRetry={() => void refetch()} />;
  }
  if (!data) return <Loading what="the curves" rows={1} height="11rem" />;
  if (groups.length === 0) {
    return (
      <p className={styles.note}>
        {active
          ? "Curves appear as soon as learning begins."
          : "This run ended before learning began, so there are no curves."}
      </p>
    );
  }
  return groups.map((group) => (
    <section key={group.stage} className={styles.group} aria-label={group.name}>
      <h3>{group.name}</h3>
      <div className={styles.charts}>
        {group.charts.map((chart) => (
          <Chart
            key={chart.title}
            title={chart.title}
            curves={chart.curves}
            format={chart.format}
            range={chart.range}
            xLabels={group.xLabels}
            syncKey={`${runId}-${group.stage}`}
          />
        ))}
      </div>
    </section>
  ));
}
