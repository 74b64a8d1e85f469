import { Link } from "react-router";

import type { Run } from "@/api/types";
import { Ago } from "@/features/results/Ago";
import { RunStatus } from "@/features/results/RunStatus";
import { count, shortCount } from "@/lib/format";
import { runName } from "@/lib/runs";

import { RunActions } from "./RunActions";
import styles from "./RunHead.module.css";

/** The name, state and settings of a run. */
export function RunHead({ run }: { run: Run }) {
  return (
    <div className={styles.head}>
      <div>
        <div className={styles.title}>
          <h2>{runName(run)}</h2>
          <RunStatus run={run} />
        </div>
        <p className={styles.facts}>
          <span>{run.recipe} recipe</span>
          <span>{shortCount(run.steps)} steps</span>
          <span>training seed {run.training_seed}</span>
          {run.n_ranked !== null && <span>{count(run.n_ranked, "ranked recording")}</span>}
          {run.parent_run_id !== null && (
            <span>
              Continues{" "}
              <Link to={`/runs/${run.parent_run_id}`}>{runName({ id: run.parent_run_id })}</Link>
            </span>
          )}
          <Ago time={run.created_at} />
        </p>
      </div>
      <RunActions run={run} />
    </div>
  );
}
