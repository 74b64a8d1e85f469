import type { Run } from "@/api/types";
import { ValueTable } from "@/components/ValueTable";
import { moment, whole } from "@/lib/format";
import { type ValueRow, valueRows } from "@/lib/recipe-values";

import styles from "./Parameters.module.css";

/** The parameters and package versions of a run. */
export function Parameters({ run }: { run: Run }) {
  const rows: ValueRow[] = [
    { section: "", name: "run", value: run.id },
    { section: "", name: "continues run", value: run.parent_run_id ?? "none" },
    { section: "", name: "recipe", value: run.recipe },
    { section: "", name: "steps", value: whole(run.steps) },
    { section: "", name: "training seed", value: whole(run.training_seed) },
    { section: "", name: "go on anyway", value: run.go_on_anyway ? "yes" : "no" },
    { section: "", name: "ranking revision", value: numberOr(run.ranking_revision) },
    { section: "", name: "ranked recordings", value: numberOr(run.n_ranked) },
    { section: "", name: "perfect recordings", value: numberOr(run.n_perfect) },
    { section: "", name: "queued", value: moment(run.created_at) },
    { section: "", name: "started", value: timeOr(run.started_at) },
    { section: "", name: "finished", value: timeOr(run.finished_at) },
    ...Object.entries(run.versions).map(([name, value]) => ({ section: "versions", name, value })),
  ];
  const recipe = valueRows(run.recipe_values).filter(({ section }) => section !== "");
  return (
    <div className={styles.parameters}>
      <ValueTable rows={rows} label="Parameters and versions" />
      <details>
        <summary className={styles.note}>All values of the recipe</summary>
        <ValueTable rows={recipe} label="Values of the recipe" />
      </details>
    </div>
  );
}

function numberOr(value: number | null): string {
  return value === null ? "not known yet" : whole(value);
}

function timeOr(time: string | null): string {
  return time === null ? "not yet" : moment(time);
}
