import type { CSSProperties } from "react";

import type { Run } from "@/api/types";
import { classes } from "@/lib/classes";
import { remaining } from "@/lib/format";
import { isActive, stageInWords, stageName, standing } from "@/lib/runs";

import styles from "./Stages.module.css";

/** How far a run is: the whole, and each of its stages. */
export function Stages({ run }: { run: Run }) {
  const at = run.stages.indexOf(run.stage);
  const going = run.status === "running" || run.status === "cancelling";
  return (
    <section aria-label="Progress">
      {isActive(run) && (
        <p className={styles.summary}>
          <span className={styles.percent}>{Math.floor(run.progress * 100)} %</span>
          <span className={styles.left}>
            {going && run.remaining_s !== null ? remaining(run.remaining_s) : standing(run)}
          </span>
        </p>
      )}
      {going && <p className={styles.what}>{stageInWords(run.stage)}</p>}
      <br />
      <ol className={styles.stages} style={{ "--count": run.stages.length } as CSSProperties}>
        {run.stages.map((stage, index) => {
          const done = doneOf(run, index, at);
          const current = going && index === at;
          return (
            <li
              key={stage}
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
                aria-label={stageName(stage)}
                aria-valuemin={0}
                aria-valuemax={100}
                aria-valuenow={Math.floor(done * 100)}
              >
                <i style={{ transform: `scaleX(${done})` }} />
              </span>
              <span className={styles.name}>
                {stageName(stage)}
                {current && ` ${Math.floor(done * 100)} %`}
              </span>
            </li>
          );
        })}
      </ol>
    </section>
  );
}

/** How much of a stage is done, from 0 to 1. */
function doneOf(run: Run, index: number, at: number): number {
  if (run.status === "done") return 1;
  if (at < 0 || index > at) return 0;
  return index < at ? 1 : run.stage_progress;
}
