/** The data of a chart: prepared once, then reduced to what its pixels can show. */
import { align, type Points } from "./series";

/** A range of the x axis. */
export type XRange = readonly [from: number, to: number];

/** The lowest and highest values around a curve, at steps of their own. */
export interface Band {
  readonly low: Points;
  readonly high: Points;
}

export interface Curve {
  readonly name: string;
  readonly points: Points;
  /** A CSS colour, such as `var(--imitator)`. */
  readonly colour: string;
  readonly dashed?: boolean;
  readonly band?: Band;
}

type Values = readonly (number | null)[];
/** In uPlot's format: x, then the values of each line; null where a line has no point. */
export type ChartData = readonly [x: readonly number[], ...lines: Values[]];

/** Aligns curves on one x axis; a curve with a band is followed by its highest and lowest values. */
export function chartData(curves: readonly Curve[]): ChartData {
  return align(
    curves.flatMap(({ points, band }) => (band ? [points, band.high, band.low] : [points])),
  );
}

/** Points per pixel column and line below which all are drawn. */
const FEW = 4;

/**
 * Reduces data to what a plot of so many pixel columns shows: of each line and column the first,
 * last, lowest and highest value, so that the drawn line has the same outline.
 *
 * @param range What is shown of the x axis; null for all. One point beyond either end is kept.
 */
export function decimate(data: ChartData, range: XRange | null, columns: number): ChartData {
  const [x, ...lines] = data;
  const first = range ? Math.max(0, firstAtLeast(x, range[0]) - 1) : 0;
  const last = range ? Math.min(x.length - 1, firstAtLeast(x, range[1])) : x.length - 1;
  if (last - first < columns * FEW) return range ? picked(data, indices(first, last)) : data;
  const from = x[first] ?? 0;
  const width = ((x[last] ?? 0) - from) / columns;
  const columnOf = (index: number) => Math.floor(((x[index] ?? 0) - from) / width);
  const kept: number[] = [];
  for (let begin = first; begin <= last;) {
    const column = columnOf(begin);
    let end = begin;
    while (end < last && columnOf(end + 1) === column) end += 1;
    const marks = lines.flatMap((values) => marksOf(values, begin, end));
    kept.push(...[...new Set(marks)].sort((a, b) => a - b));
    begin = end + 1;
  }
  return picked(data, kept);
}

/** Returns the indices of a line's first, last, lowest and highest value in a stretch. */
function marksOf(values: Values, begin: number, end: number): number[] {
  let first = -1;
  let last = -1;
  let low = -1;
  let high = -1;
  for (let index = begin; index <= end; index += 1) {
    const value = values[index] ?? null;
    if (value === null) continue;
    if (first < 0) first = low = high = index;
    last = index;
    if (value < (values[low] ?? 0)) low = index;
    if (value > (values[high] ?? 0)) high = index;
  }
  return first < 0 ? [] : [first, last, low, high];
}

/** Returns the first index whose x is at least a value; the length if there is none. */
function firstAtLeast(x: readonly number[], value: number): number {
  let low = 0;
  let high = x.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if ((x[middle] ?? 0) < value) low = middle + 1;
    else high = middle;
  }
  return low;
}

function indices(first: number, last: number): number[] {
  return Array.from({ length: Math.max(0, last - first + 1) }, (_, index) => first + index);
}

function picked([x, ...lines]: ChartData, kept: readonly number[]): ChartData {
  return [
    kept.map((index) => x[index] ?? 0),
    ...lines.map((values) => kept.map((index) => values[index] ?? null)),
  ];
}
