/** Curves: by stage, then by name, [step, value] in order of step. */

export type Points = readonly (readonly [step: number, value: number])[];
export type Series = Readonly<Record<string, Readonly<Record<string, Points>>>>;
/** As the API gives them. */
type MutableSeries = Record<string, Record<string, [number, number][]>>;

/**
 * Adds newly arrived points to curves. A worker that goes on from a checkpoint repeats steps:
 * what was drawn from the first repeated step on is replaced, so that a curve never turns back.
 */
export function mergeSeries(have: Series, more: Series): MutableSeries {
  const merged: MutableSeries = {};
  for (const stage of new Set([...Object.keys(have), ...Object.keys(more)])) {
    const curves: Record<string, [number, number][]> = {};
    const old = have[stage] ?? {};
    const added = more[stage] ?? {};
    for (const name of new Set([...Object.keys(old), ...Object.keys(added)])) {
      curves[name] = mergePoints(old[name] ?? [], added[name] ?? []);
    }
    merged[stage] = curves;
  }
  return merged;
}

function mergePoints(have: Points, more: Points): [number, number][] {
  const first = more[0]?.[0];
  const kept = first === undefined ? have : have.filter(([step]) => step < first);
  return [...kept, ...more].map(([step, value]) => [step, value]);
}

/** Several curves over one x axis, as uPlot takes them; null where a curve has no point. */
export function align(curves: readonly Points[]): [number[], ...(number | null)[][]] {
  const steps = [...new Set(curves.flatMap((points) => points.map(([step]) => step)))].sort(
    (a, b) => a - b,
  );
  const columns = curves.map((points) => {
    const values = new Map(points);
    return steps.map((step) => values.get(step) ?? null);
  });
  return [steps, ...columns];
}
