import "uplot/dist/uPlot.min.css";

import { type CSSProperties, useEffect, useId, useMemo, useRef, useState } from "react";
import uPlot from "uplot";

import { classes } from "@/lib/classes";
import { onThemeChange, resolveColour } from "@/lib/css-colour";
import { measured, percentLabels, stepLabels, tickLabels } from "@/lib/format";

import styles from "./Chart.module.css";
import { align, type Points } from "./series";

export interface Curve {
  readonly name: string;
  readonly points: Points;
  /** A CSS colour, such as `var(--imitator)`. */
  readonly colour: string;
  readonly dashed?: boolean;
}

interface ChartProps {
  title: string;
  curves: readonly Curve[];
  /** Formats a value. */
  format?: (value: number) => string;
  /** Bounds of a y axis of shares; other axes fit the values. */
  range?: readonly [number, number] | undefined;
  /** Formats the ticks of the x axis; as steps by default. */
  xLabels?: XLabels;
  /** Charts with the same key share their cursor. */
  syncKey: string;
}

/** Formats the ticks of an axis. */
export type XLabels = (ticks: readonly number[]) => string[];

const HEIGHT_PX = 170;

/** A line chart; the legend shows the values at the cursor, or else the last ones. */
export function Chart(props: ChartProps) {
  const { title, curves, format = measured, range, xLabels = stepLabels, syncKey } = props;
  const titleId = useId();
  const holder = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const [cursor, setCursor] = useState<number | null>(null);
  const [theme, setTheme] = useState(0);
  const data = useMemo(() => align(curves.map(({ points }) => points)), [curves]);
  const latest = useRef(data);
  const lines = JSON.stringify(curves.map(({ name, colour, dashed }) => [name, colour, dashed]));
  const bounds = JSON.stringify(range ?? null);

  useEffect(() => onThemeChange(() => setTheme((count) => count + 1)), []);

  useEffect(() => {
    const element = holder.current;
    if (!element) return undefined;
    const chart = new uPlot(
      optionsOf({
        width: element.clientWidth,
        lines,
        bounds,
        xLabels,
        syncKey,
        onCursor: setCursor,
      }),
      latest.current,
      element,
    );
    plot.current = chart;
    const observer = new ResizeObserver(() => {
      chart.setSize({ width: element.clientWidth, height: HEIGHT_PX });
    });
    observer.observe(element);
    return () => {
      observer.disconnect();
      chart.destroy();
      plot.current = null;
    };
  }, [lines, bounds, xLabels, syncKey, theme]);

  useEffect(() => {
    latest.current = data;
    plot.current?.setData(data);
  }, [data]);

  const at = cursor ?? data[0].length - 1;
  return (
    <figure className={styles.chart} aria-labelledby={titleId}>
      <figcaption className={styles.head}>
        <span className={styles.title} id={titleId}>
          {title}
        </span>
        <span className={styles.legend}>
          {curves.map((curve, index) => (
            <span key={curve.name} style={{ "--curve": curve.colour } as CSSProperties}>
              <i className={classes(curve.dashed && styles.dashed)} aria-hidden="true" />
              {curves.length > 1 && <>{curve.name} </>}
              {valueAt(data[index + 1], at, cursor === null, format)}
            </span>
          ))}
          {cursor !== null && <span>at {xLabels([data[0][cursor] ?? 0])}</span>}
        </span>
      </figcaption>
      <div ref={holder} className={styles.plot} />
    </figure>
  );
}

/** Formats the value at an index; with `orBefore`, the last one before it where there is a gap. */
function valueAt(
  values: readonly (number | null)[] | undefined,
  at: number,
  orBefore: boolean,
  format: (value: number) => string,
): string {
  for (let index = at; index >= 0; index -= 1) {
    const value = values?.[index];
    if (value !== null && value !== undefined) return format(value);
    if (!orBefore) break;
  }
  return "–";
}

type LineStyle = readonly [name: string, colour: string, dashed: boolean | null];

interface ChartOptions {
  readonly width: number;
  /** JSON of the LineStyle of each curve. */
  readonly lines: string;
  /** JSON of the y axis's bounds. */
  readonly bounds: string;
  readonly xLabels: XLabels;
  readonly syncKey: string;
  readonly onCursor: (index: number | null) => void;
}

function optionsOf({
  width,
  lines,
  bounds,
  xLabels,
  syncKey,
  onCursor,
}: ChartOptions): uPlot.Options {
  const range = JSON.parse(bounds) as uPlot.Range.MinMax | null;
  const axis: uPlot.Axis = {
    stroke: resolveColour("var(--ink-3)"),
    grid: { stroke: resolveColour("var(--line)"), width: 1 },
    ticks: { show: false },
    font: "11px system-ui, sans-serif",
    gap: 4,
  };
  return {
    width,
    height: HEIGHT_PX,
    padding: [8, 16, 0, 0],
    legend: { show: false },
    cursor: { sync: { key: syncKey }, drag: { x: false, y: false }, points: { size: 6 } },
    scales: { x: { time: false }, y: range ? { range: [...range] } : {} },
    axes: [
      { ...axis, size: 24, space: 70, values: (_plot, ticks) => xLabels(ticks) },
      {
        ...axis,
        size: 46,
        space: 34,
        values: (_plot, ticks) => (range ? percentLabels(ticks) : tickLabels(ticks)),
      },
    ],
    series: [
      {},
      ...(JSON.parse(lines) as LineStyle[]).map(([name, colour, dashed]) => ({
        label: name,
        stroke: resolveColour(colour),
        width: 1.75,
        spanGaps: true,
        // A line needs two points.
        points: { show: (plot: uPlot, index: number) => nPoints(plot.data[index]) === 1 },
        ...(dashed ? { dash: [5, 4] } : {}),
      })),
    ],
    hooks: { setCursor: [(chart) => onCursor(chart.cursor.idx ?? null)] },
  };
}

/** Returns how many values of a line there are. */
function nPoints(values: ArrayLike<number | null | undefined> | undefined): number {
  return values ? Array.from(values).filter((value) => value != null).length : 0;
}
