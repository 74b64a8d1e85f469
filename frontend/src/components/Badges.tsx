import type { Behaviour, Recording, Run } from "@/api/types";
import { Icon } from "@/components/controls/Icon";
import { ThingMark } from "@/components/game/ThingMark";
import { classes } from "@/lib/classes";
import { count, fixed, percent } from "@/lib/format";
import { COLUMNS, ROWS } from "@/lib/game/aliens";
import { isActive, STATUS_NAMES } from "@/lib/runs";
import { playedBy, SOURCE_NAMES } from "@/lib/things";

import styles from "./Badges.module.css";

/** Who played a recording. */
export function SourceBadge({ recording }: { recording: Recording }) {
  const { source, player } = recording;
  const name = source === "person" && player ? player : SOURCE_NAMES[source];
  return (
    <span className={styles.badge}>
      <ThingMark thing={playedBy(source)}>{name}</ThingMark>
    </span>
  );
}

/** Whether a replay gave what was recorded. */
export function VerifiedBadge({ recording }: { recording: Recording }) {
  if (recording.state === "unfinished") {
    return (
      <span className={classes(styles.badge, styles.warn)}>
        <Icon name="clock" /> not played to its end
      </span>
    );
  }
  switch (recording.verification) {
    case "verified":
      return (
        <span
          className={classes(styles.badge, styles.good)}
          title="A replay gave exactly what was recorded."
        >
          <Icon name="check" /> verified
        </span>
      );
    case "failed":
      return (
        <span className={classes(styles.badge, styles.bad)}>
          <Icon name="alert" /> not verified: {recording.verification_note}
        </span>
      );
    case "pending":
      return (
        <span className={styles.badge}>
          <Icon name="clock" /> being verified
        </span>
      );
  }
}

/** That a game was seen late by who played it; nothing where it was seen in time. */
export function LatencyBadge({ recording }: { recording: Recording }) {
  const { latency, n_frames } = recording;
  if (!latency?.is_bad) return null;
  const { p50_ms, p95_ms, frames_dropped } = latency;
  const parts = [`${percent(frames_dropped / Math.max(1, n_frames), 0)} of the frames not drawn`];
  if (p50_ms !== null && p95_ms !== null) {
    parts.unshift(`from key to screen ${fixed(p50_ms, 0)} ms, 95% within ${fixed(p95_ms, 0)} ms`);
  }
  return (
    <span className={styles.badge} title={`Played with delay: ${parts.join("; ")}.`}>
      <Icon name="clock" /> played with delay
    </span>
  );
}

/** That a game was played in slow motion or frame by frame; nothing where it was not. */
export function PaceBadge({ recording }: { recording: Recording }) {
  const { slowest_percent: slowest, single_steps: steps } = recording;
  const parts = [];
  if (slowest !== null && slowest < 100) parts.push(`slow motion, ${slowest} %`);
  if (steps) parts.push(`${count(steps, "frame")} one by one`);
  return parts.length === 0 ? null : <span className={styles.badge}>{parts.join("; ")}</span>;
}

/** A run's state. */
export function RunStatus({ run }: { run: Pick<Run, "status"> }) {
  const tone = isActive(run)
    ? styles.accent
    : run.status === "done"
      ? styles.good
      : run.status === "failed"
        ? styles.bad
        : styles.warn;
  return (
    <span className={classes(styles.badge, styles.chip, tone)}>{STATUS_NAMES[run.status]}</span>
  );
}

/** How many aliens of each column were hit. */
export function ColumnBars({
  counts,
  target,
}: {
  counts: readonly number[];
  target: Behaviour["target"];
}) {
  const wanted = new Set(target?.map(([, column]) => column));
  const columns = Array.from({ length: COLUMNS }, (_, column) => counts[column] ?? 0);
  return (
    <div
      className={styles.bars}
      role="img"
      aria-label={`Hits per column, from the left: ${columns.join(", ")}`}
    >
      {columns.map((hits, column) => (
        <span key={column} className={classes(styles.bar, wanted.has(column) && styles.wanted)}>
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
