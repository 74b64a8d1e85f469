import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import "uplot/dist/uPlot.min.css";

import { type KeyboardEvent, useEffect, useId, useMemo, useReducer, useRef, useState } from "react";
import uPlot from "uplot";

import { type EndLabel, EndLabels } from "@/features/results/labels/EndLabels";
import { onThemeChange } from "@/lib/browser/css-colour";
import { measured, NONE, stepLabels, whole } from "@/lib/format";
import { ofSigns } from "@/lib/browser/pressed-keys";

import styles from "./Chart.module.css";
import { chartData, type ChartData, type Curve, decimate, type XRange } from "./chart-data";
import { chartOptions, HEIGHT_PX, type LineStyle, type XLabels } from "./chart-options";
import { movedCursor, shownEnds } from "./cursor";
import { selected, type Zoom, zoomedIn, zoomedOut } from "./zoom";

interface ChartProps {
  title: string;
  curves: readonly Curve[];
  /** Formats a value. */
  format?: (value: number) => string;
  /** Bounds of a y axis of shares; other axes fit the values. */
  range?: readonly [number, number] | undefined;
  /** Formats the ticks of the x axis; as steps by default. */
  xLabels?: XLabels;
  /** Whether a single line has its name at its end, too. */
  isNamed?: boolean;
  zoom: Zoom;
  /** Charts with the same key share their cursor. */
  syncKey: string;
}

/** Columns that are drawn before the width is known. */
const FIRST_WIDTH_PX = 640;

/**
 * A line chart; labels at the ends of its lines have the values at the cursor, or else the last ones.
 * A drag zooms; with the focus, arrows move the cursor, + and - zoom and 0 shows everything.
 */
export function Chart(props: ChartProps) {
  const { title, curves, format = measured, range, xLabels = stepLabels, zoom, syncKey } = props;
  const { isNamed = false } = props;
  const titleId = useId();
  const holder = useRef<HTMLDivElement>(null);
  const plot = useRef<uPlot | null>(null);
  const [cursor, setCursor] = useState<number | null>(null);
  const [theme, setTheme] = useState(0);
  const [width, setWidth] = useState(FIRST_WIDTH_PX);
  const all = useMemo(() => chartData(curves), [curves]);
  const data = useMemo(() => decimate(all, zoom.range, width), [all, zoom.range, width]);
  const shown = useRef({ data, zoom });
  const labelWidth = useRef(0);
  // The labels follow what was drawn.
  const [, follow] = useReducer((draws: number) => draws + 1, 0);
  const lines = JSON.stringify(curves.map(lineStyleOf));
  const bounds = JSON.stringify(range ?? null);

  useEffect(() => onThemeChange(() => setTheme((count) => count + 1)), []);

  useEffect(() => {
    const element = holder.current;
    if (!element) return undefined;
    const chart = new uPlot(
      chartOptions({
        width: element.clientWidth,
        lines: JSON.parse(lines) as LineStyle[],
        bounds: JSON.parse(bounds) as uPlot.Range.MinMax | null,
        xLabels,
        syncKey,
        labelWidth: () => labelWidth.current,
        onDraw: follow,
        onCursor: setCursor,
        onSelect: (chosen) => {
          const { full, change } = shown.current.zoom;
          change(chosen && selected(chosen[0], chosen[1], full));
        },
      }),
      undefined,
      element,
    );
    plot.current = chart;
    draw(chart, shown.current.data, shown.current.zoom.range);
    const observer = new ResizeObserver(() => {
      chart.setSize({ width: element.clientWidth, height: HEIGHT_PX });
      setWidth(Math.max(1, element.clientWidth));
    });
    observer.observe(element);
    return () => {
      observer.disconnect();
      chart.destroy();
      plot.current = null;
    };
  }, [lines, bounds, xLabels, syncKey, theme]);

  useEffect(() => {
    shown.current = { data, zoom };
  }, [data, zoom]);

  useEffect(() => {
    if (plot.current) draw(plot.current, data, zoom.range);
  }, [data, zoom.range]);

  const [first, end] = shownEnds(data[0], zoom.range);
  const at = Math.min(cursor ?? end, end);
  const x = data[0][at] ?? 0;

  function press(event: KeyboardEvent) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const about = cursor === null ? undefined : x;
    const zooms = { "+": zoomedIn, "=": zoomedIn, "-": zoomedOut, "0": () => null };
    const zoomed = ofSigns(zooms, event);
    if (zoomed) zoom.change(zoomed(zoom, about));
    else {
      const next = movedCursor(event.key, at, first, end);
      const chart = plot.current;
      if (next === null || !chart) return;
      const left = chart.valToPos(data[0][next] ?? 0, "x");
      chart.setCursor({ left, top: HEIGHT_PX / 2 });
    }
    event.preventDefault();
  }

  /** Makes room for labels, which grows only: the lines stay where they are while values change. */
  function widen(width: number) {
    if (width <= labelWidth.current) return;
    labelWidth.current = width;
    plot.current?.redraw(false, true);
  }

  const labels = endLabels(curves, data, at, cursor === null ? null : end, format);
  const spoken = labels
    .map(({ name, value, bounds }) => [name, value, ...(bounds === null ? [] : [bounds])].join(" "))
    .join(", ");
  return (
    <figure className={styles.chart} aria-labelledby={titleId}>
      <figcaption className={styles.head}>
        <span className={styles.title} id={titleId}>
          {title}
        </span>
        {cursor !== null && (
          <span className={styles.at}>
            <Trans>at {whole(x)}</Trans>
          </span>
        )}
      </figcaption>
      <div className={styles.area}>
        <div
          ref={holder}
          className={styles.plot}
          role="slider"
          tabIndex={0}
          aria-label={t`${title}: cursor`}
          aria-valuemin={data[0][first] ?? 0}
          aria-valuemax={data[0][end] ?? 0}
          aria-valuenow={x}
          aria-valuetext={t`at ${whole(x)}: ${spoken}`}
          onKeyDown={press}
          onBlur={() => plot.current?.setCursor({ left: -10, top: -10 })}
        />
        <EndLabels labels={labels} isNamed={isNamed} plot={plot} onWidth={widen} />
      </div>
    </figure>
  );
}

function draw(chart: uPlot, data: ChartData, range: XRange | null): void {
  chart.batch(() => {
    chart.setData(data as uPlot.AlignedData, range === null);
    if (range) chart.setScale("x", { min: range[0], max: range[1] });
  });
}

function lineStyleOf({ name, colour, dashed = false, band }: Curve): LineStyle {
  return { name, colour, dashed, band: band !== undefined };
}

/**
 * Returns the labels of the curves, with their values at an index.
 *
 * @param end The last index that is shown; null where that is the index.
 */
function endLabels(
  curves: readonly Curve[],
  [, ...columns]: ChartData,
  at: number,
  end: number | null,
  format: (value: number) => string,
): EndLabel[] {
  let column = 0;
  return curves.map(({ name, colour, dashed = false, band }) => {
    const [line, high, low] = [columns[column], columns[column + 1], columns[column + 2]];
    column += band ? 3 : 1;
    const valueOf = (values: Values) => {
      const value = end === null ? lastValue(values, at) : (values?.[at] ?? null);
      return value === null ? NONE : format(value);
    };
    const bounds = band ? t`(${valueOf(low)} to ${valueOf(high)})` : null;
    return { name, colour, dashed, value: valueOf(line), bounds, last: lastValue(line, end ?? at) };
  });
}

type Values = readonly (number | null)[] | undefined;

/** Returns the value at an index, or the last one before it; null if there is none. */
function lastValue(values: Values, index: number): number | null {
  for (let at = index; at >= 0; at -= 1) {
    const value = values?.[at] ?? null;
    if (value !== null) return value;
  }
  return null;
}
