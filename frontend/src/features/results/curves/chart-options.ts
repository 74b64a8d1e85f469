/** How uPlot draws a chart. */
import type uPlot from "uplot";

import { resolveColour } from "@/lib/browser/css-colour";
import { percentLabels, tickLabels } from "@/lib/format";

import type { XRange } from "./chart-data";

export const HEIGHT_PX = 170;
/** Half the label of the last tick. */
const NARROWEST_RIGHT_PX = 16;
/** A shorter drag is a click. */
const SHORTEST_DRAG_PX = 5;

/** Formats the ticks of an axis. */
export type XLabels = (ticks: readonly number[]) => string[];

/** What a curve looks like. */
export interface LineStyle {
  readonly name: string;
  readonly colour: string;
  readonly dashed: boolean;
  readonly band: boolean;
}

interface ChartOptions {
  readonly width: number;
  readonly lines: readonly LineStyle[];
  /** Bounds of a y axis of shares; other axes fit the values. */
  readonly bounds: uPlot.Range.MinMax | null;
  readonly xLabels: XLabels;
  readonly syncKey: string;
  /** Returns the room for the labels at the right, in pixels. */
  readonly labelWidth: () => number;
  readonly onDraw: () => void;
  readonly onCursor: (index: number | null) => void;
  /** A drag has selected a range, or a double click everything. */
  readonly onSelect: (range: XRange | null) => void;
}

/** Returns the options of a chart. */
export function chartOptions(options: ChartOptions): uPlot.Options {
  const { width, lines, bounds, xLabels, syncKey, labelWidth, onDraw, onCursor, onSelect } =
    options;
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
    padding: [8, () => Math.max(NARROWEST_RIGHT_PX, labelWidth()), 0, 0],
    legend: { show: false },
    cursor: {
      sync: { key: syncKey },
      drag: { x: true, y: false, setScale: false },
      points: { size: 6 },
      bind: {
        dblclick: () => () => {
          onSelect(null);
          return null;
        },
      },
    },
    scales: { x: { time: false }, y: bounds ? { range: [...bounds] } : {} },
    axes: [
      { ...axis, size: 24, space: 70, values: (_plot, ticks) => xLabels(ticks) },
      {
        ...axis,
        size: 46,
        space: 34,
        values: (_plot, ticks) => (bounds ? percentLabels(ticks) : tickLabels(ticks)),
      },
    ],
    series: [{}, ...lines.flatMap(seriesOf)],
    bands: bandsOf(lines),
    hooks: {
      draw: [onDraw],
      setCursor: [(chart) => onCursor(chart.cursor.idx ?? null)],
      setSelect: [
        (chart) => {
          const { left, width: dragged } = chart.select;
          if (dragged < SHORTEST_DRAG_PX) return;
          onSelect([chart.posToVal(left, "x"), chart.posToVal(left + dragged, "x")]);
          chart.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
        },
      ],
    },
  };
}

/** The line of a curve, and the invisible edges of its band. */
function seriesOf({ name, colour, dashed, band }: LineStyle): uPlot.Series[] {
  const line: uPlot.Series = {
    label: name,
    stroke: resolveColour(colour),
    width: 1.75,
    spanGaps: true,
    // A line needs two points.
    points: { show: (plot: uPlot, index: number) => nPoints(plot.data[index]) === 1 },
    ...(dashed ? { dash: [5, 4] } : {}),
  };
  const edge: uPlot.Series = { width: 0, spanGaps: true, points: { show: false } };
  return band ? [line, edge, { ...edge }] : [line];
}

function bandsOf(lines: readonly LineStyle[]): uPlot.Band[] {
  let index = 1;
  return lines.flatMap(({ colour, band }) => {
    const at = index;
    index += band ? 3 : 1;
    const fill = resolveColour(`color-mix(in srgb, ${colour} 20%, transparent)`);
    return band ? [{ series: [at + 1, at + 2] as [number, number], fill }] : [];
  });
}

/** Returns how many values of a line there are. */
function nPoints(values: ArrayLike<number | null | undefined> | undefined): number {
  return values ? Array.from(values).filter((value) => value != null).length : 0;
}
