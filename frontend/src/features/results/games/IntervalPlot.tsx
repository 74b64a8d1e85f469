import type { CSSProperties } from "react";

import { classes } from "@/lib/classes";
import type { Interval } from "@/lib/format";
import { type Actor, actorColour } from "@/lib/actors";

import styles from "./IntervalPlot.module.css";

interface IntervalPlotProps {
  intervals: readonly {
    readonly actor: Actor;
    readonly interval: Interval;
    /** A CSS colour; the actor's by default. */
    readonly colour?: string | undefined;
  }[];
  low: number;
  high: number;
}

/** Means and intervals on a common axis. Decorative: the table has the numbers. */
export function IntervalPlot({ intervals, low, high }: IntervalPlotProps) {
  const at = (value: number) =>
    Math.min(Math.max(((value - low) / (high - low || 1)) * 100, 0), 100);
  return (
    <div className={styles.plot} aria-hidden="true">
      {intervals.map(({ actor, interval, colour = actorColour(actor) }, index) => {
        const top = `${((index + 1) / (intervals.length + 1)) * 100}%`;
        const left = at(interval.low);
        return (
          <div key={actor} style={{ "--actor": colour } as CSSProperties}>
            <i
              className={styles.range}
              style={{ top, left: `${left}%`, width: `${at(interval.high) - left}%` }}
            />
            <i
              className={classes(styles.mean, actor === "clone" && styles.clone)}
              style={{ top, left: `${at(interval.mean)}%` }}
            />
          </div>
        );
      })}
    </div>
  );
}
