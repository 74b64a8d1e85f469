/** The nested values of a recipe as rows of a table. */

import { t } from "@lingui/core/macro";

import { whole } from "./format";

export interface ValueRow {
  /** Such as "policy"; "" for top-level values. */
  readonly section: string;
  readonly name: string;
  readonly value: string;
}

/** Flattens a recipe; underscores in names become spaces. */
export function valueRows(values: Readonly<Record<string, unknown>>): readonly ValueRow[] {
  const rows: ValueRow[] = [];
  for (const [key, value] of Object.entries(values)) {
    if (isRecord(value)) {
      for (const [inner, innerValue] of Object.entries(value)) {
        rows.push({ section: key, name: words(inner), value: show(innerValue) });
      }
    } else if (key !== "summary") {
      rows.push({ section: "", name: words(key), value: show(value) });
    }
  }
  return rows.sort((a, b) => Number(a.section !== "") - Number(b.section !== ""));
}

function isRecord(value: unknown): value is Record<string, unknown> {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

function words(name: string): string {
  return name.replaceAll("_", " ");
}

const MOST_SHOWN = 4;

function show(value: unknown): string {
  if (Array.isArray(value)) {
    const shown = value.slice(0, MOST_SHOWN).map(show);
    const last = value.at(-1) as unknown;
    return value.length > MOST_SHOWN + 1
      ? `${shown.join(", ")} … ${show(last)}`
      : value.map(show).join(", ");
  }
  if (typeof value === "boolean") return value ? t`yes` : t`no`;
  if (typeof value === "number") {
    if (Number.isInteger(value)) return whole(value);
    return Math.abs(value) < 0.001 ? value.toExponential().replace("-", "−") : String(value);
  }
  if (value === null) return t`none`;
  return typeof value === "string" ? value : JSON.stringify(value);
}
