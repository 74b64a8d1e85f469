import type { XRange } from "./chart-data";

/** Points that a page key passes. */
const PAGE = 20;

/** Returns the first and the last of a chart's points that lie within what is shown. */
export function shownEnds(x: readonly number[], range: XRange | null): readonly [number, number] {
  const last = Math.max(0, x.length - 1);
  if (range === null) return [0, last];
  const first = (x[0] ?? 0) < range[0] ? 1 : 0;
  return [Math.min(first, last), (x[last] ?? 0) > range[1] ? Math.max(first, last - 1) : last];
}

/**
 * Returns the point to which a key moves a chart's cursor; null for any other key.
 *
 * @param first The first point that is shown, and `end` the last.
 */
export function movedCursor(key: string, at: number, first: number, end: number): number | null {
  const by: Readonly<Record<string, number>> = {
    ArrowLeft: at - 1,
    ArrowRight: at + 1,
    PageDown: at - PAGE,
    PageUp: at + PAGE,
    Home: first,
    End: end,
  };
  const next = by[key];
  return next === undefined ? null : Math.min(Math.max(next, first), end);
}
