import { t } from "@lingui/core/macro";
import { Plural, Trans } from "@lingui/react/macro";
import { useQueries } from "@tanstack/react-query";
import { useMemo } from "react";

import { Button } from "@/components/controls/Button";
import { Loading, Notice } from "@/components/feedback/States";
import { curvesCsv } from "@/features/results/curves/csv";
import { chartHint, CurveGroupView } from "@/features/results/curves/CurveGroupView";
import { useMetricsQueries } from "@/features/results/curves/metrics";
import { runName } from "@/lib/runs";
import { saveFile } from "@/lib/browser/save-file";

import { comparedGroups } from "./compared-curves";
import type { SeedGroup } from "./compared-runs";
import styles from "./ComparePage.module.css";

/** The training curves of runs over each other; means where runs differ by seed only. */
export function ComparedCurves({ groups }: { groups: readonly SeedGroup[] }) {
  const runs = groups.flatMap((group) => group.runs);
  const queries = useQueries({ queries: useMetricsQueries(runs.map(({ id }) => id)) });
  const found = JSON.stringify(queries.map(({ data }) => data?.last ?? null));
  const charts = useMemo(() => {
    const seriesOf = new Map(runs.map(({ id }, index) => [id, queries[index]?.data?.series ?? {}]));
    return comparedGroups(
      groups.map(({ runs: same, colour, dashed }) => ({
        colour,
        dashed,
        runs: same.map((run) => ({ name: runName(run), series: seriesOf.get(run.id) ?? {} })),
      })),
    );
    // `found` changes when any of the curves does.
    // eslint-disable-next-line react-hooks/exhaustive-deps
  }, [found]);
  if (queries.some(({ isPending }) => isPending)) {
    return <Loading what={t`the curves`} rows={1} height="11rem" />;
  }
  const failed = queries.filter(({ error, data }) => error && !data).length;
  const save = () => {
    const text = curvesCsv(
      runs.map((run, index) => ({ run: runName(run), series: queries[index]?.data?.series ?? {} })),
    );
    saveFile(new Blob([text], { type: "text/csv" }), "compared-curves.csv");
  };
  return (
    <>
      {failed > 0 && (
        <Notice live>
          <p>
            <Trans>
              The curves of <Plural value={failed} one="# run" other="# runs" /> could not be
              loaded.
            </Trans>
          </p>
        </Notice>
      )}
      {charts.map((group) => (
        <CurveGroupView
          key={group.stage}
          level="h2"
          group={group}
          isNamed
          syncKey={`compared-${group.stage}`}
        />
      ))}
      {charts.length > 0 && (
        <div className={styles.section}>
          <p className={styles.note}>
            <Trans>
              Runs that differ only in their training seed are one line, their mean, in a band from
              lowest to highest. {chartHint()}
            </Trans>
          </p>
          <div>
            <Button icon="download" onClick={save}>
              <Trans>Download the curves (CSV)</Trans>
            </Button>
          </div>
        </div>
      )}
    </>
  );
}
