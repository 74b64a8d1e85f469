import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { useMemo } from "react";

import { Button } from "@/components/controls/Button";
import { Failed, Loading } from "@/components/feedback/States";
import { saveFile } from "@/lib/browser/save-file";

import { curvesCsv } from "./csv";
import { curveGroups } from "./curve-groups";
import { chartHint, CurveGroupView } from "./CurveGroupView";
import styles from "./Curves.module.css";
import { useMetricsQuery } from "./metrics";

/** The training curves of a run, updated live. */
export function Curves({ runId, active }: { runId: string; active: boolean }) {
  const { data, error, refetch } = useQuery(useMetricsQuery(runId));
  const groups = useMemo(() => (data ? curveGroups(data.series) : []), [data]);
  if (error && !data) {
    return <Failed what={t`The curves`} error={error} onRetry={() => void refetch()} />;
  }
  if (!data) return <Loading what={t`the curves`} rows={1} height="11rem" />;
  if (groups.length === 0) {
    return (
      <p className={styles.note}>
        {active
          ? t`Curves appear as soon as learning begins.`
          : t`This run ended before learning began, so there are no curves.`}
      </p>
    );
  }
  const save = () => {
    const text = curvesCsv([{ run: runId, series: data.series }]);
    saveFile(new Blob([text], { type: "text/csv" }), `curves-${runId.slice(0, 6)}.csv`);
  };
  return (
    <>
      {groups.map((group) => (
        <CurveGroupView key={group.stage} group={group} syncKey={`${runId}-${group.stage}`} />
      ))}
      <div className={styles.foot}>
        <p className={styles.note}>{chartHint()}</p>
        <Button icon="download" onClick={save}>
          <Trans>Download the curves (CSV)</Trans>
        </Button>
      </div>
    </>
  );
}
