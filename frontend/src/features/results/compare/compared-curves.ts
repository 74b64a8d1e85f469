/** Curves of several runs over each other. */
import { t } from "@lingui/core/macro";

import type { Curve } from "@/features/results/curves/chart-data";
import { type CurveGroup, plan } from "@/features/results/curves/curve-groups";
import type { Points, Series } from "@/features/results/curves/series";

/** A line of every chart: a run, or runs that differ by their training seed only. */
export interface ComparedLine {
  readonly colour: string;
  readonly dashed: boolean;
  readonly runs: readonly NamedSeries[];
}

interface NamedSeries {
  readonly name: string;
  readonly series: Series;
}

/** Returns the charts that have points, one for each curve of a run's charts. */
export function comparedGroups(lines: readonly ComparedLine[]): readonly CurveGroup[] {
  return plan()
    .map((group) => ({
      stage: group.stage,
      name: group.name,
      xLabels: group.xLabels,
      charts: group.charts
        .flatMap((chart) =>
          chart.curves.map(({ key, name }) => ({
            title: chart.curves.length > 1 ? `${chart.title}: ${name}` : chart.title,
            format: chart.format,
            ...(chart.range ? { range: chart.range } : {}),
            curves: lines.flatMap((line) => curveOf(line, group.stage, key)),
          })),
        )
        .filter(({ curves }) => curves.length > 0),
    }))
    .filter(({ charts }) => charts.length > 0);
}

function curveOf(line: ComparedLine, stage: string, key: string): Curve[] {
  const { colour, dashed } = line;
  const runs = line.runs
    .map(({ name, series }) => ({ name, points: series[stage]?.[key] ?? [] }))
    .filter(({ points }) => points.length > 0);
  const [first] = runs;
  if (!first) return [];
  const { name, points } = first;
  if (runs.length === 1) return [{ name, colour, dashed, points }];
  const all = t`${name} and ${runs.length - 1} more`;
  return [{ name: all, colour, dashed, ...meanWithBand(runs.map((run) => run.points)) }];
}

/**
 * Returns the mean of curves with their lowest and highest values, at every step of any of them that
 * lies within all; values between the points of a curve are interpolated linearly.
 */
export function meanWithBand(curves: readonly Points[]): Required<Pick<Curve, "points" | "band">> {
  const from = Math.max(...curves.map((points) => points[0]?.[0] ?? Infinity));
  const to = Math.min(...curves.map((points) => points.at(-1)?.[0] ?? -Infinity));
  const steps = [...new Set(curves.flatMap((points) => points.map(([step]) => step)))]
    .filter((step) => step >= from && step <= to)
    .sort((a, b) => a - b);
  const columns = curves.map((points) => valuesAt(points, steps));
  const at = (of: (values: readonly number[]) => number): Points =>
    steps.map((step, index) => [step, of(columns.map((values) => values[index] ?? NaN))] as const);
  return {
    points: at((values) => values.reduce((sum, value) => sum + value, 0) / values.length),
    band: { low: at((values) => Math.min(...values)), high: at((values) => Math.max(...values)) },
  };
}

/** Interpolates a curve at increasing steps within it. */
function valuesAt(points: Points, steps: readonly number[]): number[] {
  let next = 0;
  return steps.map((step) => {
    while ((points[next]?.[0] ?? Infinity) < step) next += 1;
    const [after, high] = points[next] ?? [step, NaN];
    const [before, low] = points[next - 1] ?? [after, high];
    return after === step || after === before
      ? high
      : low + ((high - low) * (step - before)) / (after - before);
  });
}
