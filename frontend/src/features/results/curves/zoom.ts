/** The part of the x axis that charts show, shared by those of a group. */
import { useMemo, useState } from "react";

import type { Curve, XRange } from "./chart-data";

export interface Zoom {
  /** Null while everything is shown. */
  readonly range: XRange | null;
  /** From the first point of any curve to the last. */
  readonly full: XRange;
  readonly change: (range: XRange | null) => void;
}

/** The zoom of charts, which begins with everything. */
export function useZoom(charts: readonly { readonly curves: readonly Curve[] }[]): Zoom {
  const [range, change] = useState<XRange | null>(null);
  const full = useMemo(() => extentOf(charts.flatMap(({ curves }) => curves)), [charts]);
  return { range, full, change };
}

function extentOf(curves: readonly Curve[]): XRange {
  const ends = curves.flatMap(({ points }) => [points[0]?.[0] ?? 0, points.at(-1)?.[0] ?? 0]);
  return [Math.min(...ends), Math.max(...ends)];
}

const IN = 0.5;
/** Most times the whole axis is enlarged. */
const MOST = 1000;

/** Returns half of what is shown, about a value or the middle. */
export function zoomedIn({ range, full }: Zoom, about?: number): XRange | null {
  return scaled(range ?? full, full, IN, about);
}

/** Returns twice what is shown. */
export function zoomedOut({ range, full }: Zoom, about?: number): XRange | null {
  return scaled(range ?? full, full, 1 / IN, about);
}

/** Returns what is shown, moved by a share of its width and kept within the data. */
export function moved({ range, full }: Zoom, share: number): XRange | null {
  if (range === null) return null;
  const width = range[1] - range[0];
  const from = clamp(range[0] + share * width, full[0], full[1] - width);
  return [from, from + width];
}

/** Returns a range that a drag has selected, kept within the data. */
export function selected(from: number, to: number, full: XRange): XRange | null {
  return scaled([from, to], full, 1);
}

function scaled(range: XRange, full: XRange, factor: number, about?: number): XRange | null {
  const most = full[1] - full[0];
  const before = range[1] - range[0];
  const width = Math.max(before * factor, most / MOST);
  if (width >= most) return null;
  const centre = clamp(about ?? (range[0] + range[1]) / 2, range[0], range[1]);
  const share = before > 0 ? (centre - range[0]) / before : 0.5;
  const from = clamp(centre - share * width, full[0], full[1] - width);
  return [from, from + width];
}

function clamp(value: number, low: number, high: number): number {
  return Math.min(Math.max(value, low), high);
}
