import { t } from "@lingui/core/macro";

import type { Behaviour } from "@/api/types";
import { classes } from "@/lib/classes";
import { COLUMNS, ROWS } from "@/lib/game/aliens";

import styles from "./ColumnBars.module.css";

/** The number of hits in each column of aliens. */
export function ColumnBars({
  counts,
  target,
}: {
  counts: readonly number[];
  target: Behaviour["target"];
}) {
  const targetColumns = new Set(target?.map(([, column]) => column));
  const columns = Array.from({ length: COLUMNS }, (_, column) => counts[column] ?? 0);
  return (
    <div
      className={styles.bars}
      role="img"
      aria-label={t`Hits per column, from the left: ${columns.join(", ")}`}
    >
      {columns.map((hits, column) => (
        <span
          key={column}
          className={classes(styles.bar, targetColumns.has(column) && styles.target)}
        >
          <i>
            {Array.from({ length: ROWS }, (_, row) => (
              <b key={row} data-on={row < hits ? "" : undefined} />
            ))}
          </i>
          {column + 1}
        </span>
      ))}
    </div>
  );
}
