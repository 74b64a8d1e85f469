/** Curves as a table of text, one point a row. */
import type { Series } from "./series";

/** A run's curves. */
export interface NamedSeries {
  readonly run: string;
  readonly series: Series;
}

/** Returns curves as CSV: run, stage, curve, step, value; lines end as RFC 4180 has it. */
export function curvesCsv(runs: readonly NamedSeries[]): string {
  const rows = ["run,stage,curve,step,value"];
  for (const { run, series } of runs) {
    for (const [stage, curves] of Object.entries(series)) {
      for (const [name, points] of Object.entries(curves)) {
        const begin = [run, stage, name].map(quoted).join(",");
        for (const [step, value] of points) rows.push(`${begin},${step},${value}`);
      }
    }
  }
  return `${rows.join("\r\n")}\r\n`;
}

function quoted(text: string): string {
  // Spreadsheets take a text that begins so for a formula.
  const safe = /^[=+\-@\t\r]/.test(text) ? `'${text}` : text;
  return /[",\r\n]/.test(safe) ? `"${safe.replaceAll('"', '""')}"` : safe;
}
