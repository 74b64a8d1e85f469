import { t } from "@lingui/core/macro";
import { useQuery } from "@tanstack/react-query";
import type { CSSProperties } from "react";

import { activeRunsQuery } from "@/api/runs";
import type { Run } from "@/api/types";
import { classes } from "@/lib/classes";
import { percentDone, remaining } from "@/lib/format";
import { currentStage, isActive, statusLine } from "@/lib/runs";

import styles from "./Stages.module.css";

/** The progress of a run, in total and by stage. */
export function Stages({ run }: { run: Run }) {
  const at = run.stages.findIndex(({ name }) => name === run.stage);
  // A run's place in the queue changes with other runs.
  const { data: waiting } = useQuery({ ...activeRunsQuery, enabled: run.status === "queued" });
  const latest = waiting?.find(({ id }) => id === run.id) ?? run;
  const running = run.status === "running" || run.status === "cancelling";
  return (
    <section aria-label={t`Progress`}>
      {isActive(run) && (
        <p className={styles.summary}>
          <span className={styles.percent}>{percentDone(run.progress)}</span>
          <span className={styles.left}>
            {run.status === "running" && run.remaining_s !== null
              ? remaining(run.remaining_s)
              : statusLine(latest)}
          </span>
        </p>
      )}
      {running && <p className={styles.what}>{currentStage(run)?.summary}</p>}
      <ol className={styles.stages} style={{ "--count": run.stages.length } as CSSProperties}>
        {run.stages.map((stage, index) => {
          const done = doneOf(run, index, at);
          const current = running && index === at;
          return (
            <li
              key={stage.name}
              className={classes(
                styles.stage,
                done === 1 && styles.done,
                current && styles.current,
              )}
              aria-current={current ? "step" : undefined}
            >
              <span
                className={styles.bar}
                role="progressbar"
                aria-label={stage.label}
                aria-valuemin={0}
                aria-valuemax={100}
                aria-valuenow={Math.floor(done * 100)}
              >
                <i style={{ transform: `scaleX(${done})` }} />
              </span>
              <span className={styles.name}>
                {stage.label}
                {current && ` ${percentDone(done)}`}
              </span>
            </li>
          );
        })}
      </ol>
    </section>
  );
}

/** Returns the completed fraction of a stage, 0 to 1. */
function doneOf(run: Run, index: number, at: number): number {
  if (run.status === "done") return 1;
  if (at < 0 || index > at) return 0;
  return index < at ? 1 : run.stage_progress;
}
