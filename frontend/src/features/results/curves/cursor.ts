/** Points that a page key passes. */
const PAGE = 20;

/** Returns the point to which a key moves a chart's cursor; null for any other key. */
export function movedCursor(key: string, at: number, end: number): number | null {
  const by: Readonly<Record<string, number>> = {
    ArrowLeft: at - 1,
    ArrowRight: at + 1,
    PageDown: at - PAGE,
    PageUp: at + PAGE,
    Home: 0,
    End: end,
  };
  const next = by[key];
  return next === undefined ? null : Math.min(Math.max(next, 0), end);
}
