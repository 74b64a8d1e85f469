import type { CSSProperties } from "react";

import { classes } from "@/lib/classes";
import { type Actor, ACTOR_SHAPES, actorColour } from "@/lib/actors";

import { type Measure, rangeOf, ticksOf, write } from "./measure";
import styles from "./ScatterPlot.module.css";

export interface ScatterPoint {
  readonly key: string | number;
  readonly x: number;
  readonly y: number;
  readonly actor: Actor;
  readonly hollow?: boolean;
  /** Shown on hover. */
  readonly title: string;
}

interface ScatterPlotProps {
  /** Accessible name; a table beside the plot has the numbers. */
  label: string;
  points: readonly ScatterPoint[];
  /** What of the reward the vertical axis shows. */
  measure: Measure;
  /** Ends of the horizontal axis. */
  range: readonly [number, number];
  xTicks: readonly number[];
  /** A shaded range of the horizontal axis. */
  band?: readonly [number, number] | undefined;
}

const WIDTH = 420;
const HEIGHT = 260;
const LEFT = 48;
const BOTTOM = 34;
const TOP = 8;
const MARK = 10;

/** A scatter plot, with the colour and shape of each actor. */
export function ScatterPlot({ label, points, measure, range, xTicks, band }: ScatterPlotProps) {
  const [low, high] = rangeOf(
    measure,
    points.map((point) => point.y),
  );
  const x = (value: number) => LEFT + ((value - range[0]) / (range[1] - range[0])) * (WIDTH - LEFT);
  const y = (value: number) =>
    TOP + (1 - (value - low) / (high - low || 1)) * (HEIGHT - TOP - BOTTOM);
  return (
    <svg className={styles.plot} viewBox={`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label={label}>
      {band && (
        <rect
          className={styles.band}
          x={x(band[0])}
          y={0}
          width={x(band[1]) - x(band[0])}
          height={HEIGHT - BOTTOM + TOP}
        />
      )}
      {ticksOf(measure, low, high).map((value) => (
        <g key={value}>
          <line className={styles.grid} x1={LEFT} x2={WIDTH} y1={y(value)} y2={y(value)} />
          <text x={LEFT - 8} y={y(value) + 4} textAnchor="end">
            {write(measure, value)}
          </text>
        </g>
      ))}
      {xTicks.map((value) => (
        <text key={value} x={x(value)} y={HEIGHT - 10} textAnchor="middle">
          {String(value).replace("-", "−")}
        </text>
      ))}
      {points.map(({ key, x: across, y: up, actor, hollow = false, title }) => (
        <path
          key={key}
          className={classes(styles.mark, hollow && styles.hollow)}
          style={{ "--actor": actorColour(actor) } as CSSProperties}
          d={ACTOR_SHAPES[actor]}
          transform={`translate(${x(across) - MARK / 2} ${y(up) - MARK / 2})`}
        >
          <title>{title}</title>
        </path>
      ))}
    </svg>
  );
}
