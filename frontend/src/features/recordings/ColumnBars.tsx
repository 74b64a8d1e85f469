import { t } from "@lingui/core/macro";

import type { Behaviour } from "@/api/types";
import { useGame } from "@/games/game";
import { classes } from "@/lib/classes";

import styles from "./ColumnBars.module.css";

/** The number of items taken in each column of their grid, where a behaviour has targets among them. */
export function ColumnBars({
  counts,
  target,
}: {
  counts: readonly number[];
  target: Behaviour["target"];
}) {
  const { items } = useGame();
  if (!items || !target) return null;
  const targetColumns = new Set(target.map(([, column]) => column));
  const columns = Array.from({ length: items.columns }, (_, column) => counts[column] ?? 0);
  return (
    <div
      className={styles.bars}
      style={{ gridTemplateColumns: `repeat(${items.columns}, 1fr)` }}
      role="img"
      aria-label={t`Hits per column, from the left: ${columns.join(", ")}`}
    >
      {columns.map((hits, column) => (
        <span
          key={column}
          className={classes(styles.bar, targetColumns.has(column) && styles.target)}
        >
          <i>
            {Array.from({ length: items.rows }, (_, row) => (
              <b key={row} data-on={row < hits ? "" : undefined} />
            ))}
          </i>
          {column + 1}
        </span>
      ))}
    </div>
  );
}
