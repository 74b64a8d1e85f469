/** Curves by stage and name, as [step, value] in order of step. */

export type Points = readonly (readonly [step: number, value: number])[];
export type Series = Readonly<Record<string, Readonly<Record<string, Points>>>>;
/** As in the API. */
type MutableSeries = Record<string, Record<string, [number, number][]>>;

/**
 * Appends new points to curves. A worker that resumes from a checkpoint repeats steps: points from
 * the first repeated step on are replaced, so that steps always increase.
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

/** Aligns curves on one x axis in uPlot's format; null where a curve has no point. */
export function align(curves: readonly Points[]): [number[], ...(number | null)[][]] {
  const [first] = curves;
  if (first && curves.every((points) => hasStepsOf(points, first))) {
    return [
      first.map(([step]) => step),
      ...curves.map((points) => points.map(([, value]) => value)),
    ];
  }
  const steps = [...new Set(curves.flatMap((points) => points.map(([step]) => step)))].sort(
    (a, b) => a - b,
  );
  const columns = curves.map((points) => {
    const values = new Map(points);
    return steps.map((step) => values.get(step) ?? null);
  });
  return [steps, ...columns];
}

function hasStepsOf(points: Points, others: Points): boolean {
  return (
    points.length === others.length && points.every(([step], index) => step === others[index]?.[0])
  );
}
