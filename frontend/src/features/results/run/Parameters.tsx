import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { Run } from "@/api/types";
import { ValueTable } from "@/components/ValueTable";
import { moment, whole } from "@/lib/format";
import { type ValueRow, valueRows } from "@/lib/recipe-values";

import styles from "./Parameters.module.css";

/** The parameters and package versions of a run. */
export function Parameters({ run }: { run: Run }) {
  const rows: ValueRow[] = [
    { section: "", name: t`run`, value: run.id },
    { section: "", name: t`continues run`, value: run.parent_run_id ?? t`none` },
    { section: "", name: t`recipe`, value: run.recipe },
    { section: "", name: t`steps`, value: whole(run.steps) },
    { section: "", name: t`training seed`, value: whole(run.training_seed) },
    { section: "", name: t`go on anyway`, value: run.go_on_anyway ? t`yes` : t`no` },
    ...(run.device === "gpu" ? [{ section: "", name: t`device`, value: t`GPU` }] : []),
    { section: "", name: t`ranking revision`, value: numberOr(run.ranking_revision) },
    { section: "", name: t`ranked games`, value: numberOr(run.n_ranked) },
    { section: "", name: t`perfect recordings`, value: numberOr(run.n_perfect) },
    { section: "", name: t`queued`, value: moment(run.created_at) },
    { section: "", name: t`started`, value: timeOr(run.started_at) },
    { section: "", name: t`finished`, value: timeOr(run.finished_at) },
    ...Object.entries(run.versions).map(([name, value]) => ({ section: "versions", name, value })),
  ];
  const recipe = valueRows(run.recipe_values).filter(({ section }) => section !== "");
  return (
    <div className={styles.parameters}>
      <ValueTable rows={rows} label={t`Parameters and versions`} />
      <details>
        <summary className={styles.note}>
          <Trans>All values of the recipe</Trans>
        </summary>
        <ValueTable rows={recipe} label={t`Values of the recipe`} />
      </details>
    </div>
  );
}

function numberOr(value: number | null): string {
  return value === null ? t`not known yet` : whole(value);
}

function timeOr(time: string | null): string {
  return time === null ? t`not yet` : moment(time);
}
