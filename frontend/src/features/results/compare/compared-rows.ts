/** The rows of the table that compares runs; every row has a cell for each run. */

import { t } from "@lingui/core/macro";

import type { Interval, PolicySummary, Run } from "@/api/types";
import { fixed, percent, whole, wholeShare } from "@/lib/format";
import { valueRows } from "@/lib/recipe-values";
import { shortId } from "@/lib/runs";

export interface ResultRow {
  readonly name: string;
  readonly cells: readonly (Interval | null)[];
  readonly write: (value: number) => string;
  /** The upper end of the axis on which the cells are drawn; the lower is 0. */
  readonly high: number;
}

const oneDigit = (value: number) => fixed(value, 1);
const wholePercent = (value: number) => percent(value, 0);

const measures = (): readonly {
  readonly key: keyof PolicySummary;
  readonly name: string;
  readonly write: (value: number) => string;
  /** The highest value there can be; null where there is none. */
  readonly most: number | null;
}[] => [
  { key: "targets", name: t`Targets hit`, write: oneDigit, most: null },
  { key: "strays", name: t`Strays`, write: oneDigit, most: null },
  { key: "death_rate", name: t`Death rate`, write: wholePercent, most: 1 },
  { key: "perfect", name: t`Perfect games`, write: wholePercent, most: 1 },
];

/** Returns a policy's results in greedy games, without measures that no run has. */
export function resultRows(
  runs: readonly Run[],
  policy: "imitator" | "clone",
  nTargets: number | null,
): readonly ResultRow[] {
  const understood = runs.map(({ headline }) => headline?.understood?.[policy] ?? null);
  return [
    {
      name: t`Worth by what Tril understood (100%: a full game)`,
      write: wholeShare,
      cells: understood,
      high: Math.max(1, ...understood.map((share) => share?.high ?? 0)),
    },
    ...measures().map(({ key, name, write, most }) => ({
      name: key === "targets" && nTargets !== null ? t`${name}, of ${nTargets}` : name,
      write,
      cells: runs.map((run) => run.headline?.[policy]?.[key] ?? null),
      high: (key === "targets" ? nTargets : most) ?? highest(runs, key),
    })),
  ].filter(({ cells }) => cells.some((cell) => cell !== null));
}

/** Returns the highest upper bound of any run's imitator or clone; at least 1. */
function highest(runs: readonly Run[], key: keyof PolicySummary): number {
  const bounds = runs.flatMap(({ headline }) =>
    [headline?.imitator, headline?.clone].flatMap((policy) => policy?.[key]?.high ?? []),
  );
  return Math.max(1, ...bounds);
}

export interface DifferenceRow {
  readonly name: string;
  readonly cells: readonly string[];
}

/** Returns the settings in which the runs differ. */
export function differenceRows(runs: readonly Run[]): readonly DifferenceRow[] {
  const settings = runs.map(settingsOf);
  const names = [...new Set(settings.flatMap((one) => [...one.keys()]))];
  return names
    .map((name) => ({ name, cells: settings.map((one) => one.get(name) ?? t`none`) }))
    .filter(({ cells }) => new Set(cells).size > 1);
}

function settingsOf(run: Run): ReadonlyMap<string, string> {
  const parent = run.parent_run_id;
  return new Map([
    [t`behaviour`, run.behaviour_name],
    [t`recipe`, run.recipe],
    [t`steps`, whole(run.steps)],
    [t`training seed`, String(run.training_seed)],
    [t`go on anyway`, run.go_on_anyway ? t`yes` : t`no`],
    [t`continues`, parent === null ? t`none` : shortId(parent)],
    [t`ranking revision`, run.ranking_revision === null ? t`none` : whole(run.ranking_revision)],
    [t`ranked games`, run.n_ranked === null ? t`none` : whole(run.n_ranked)],
    [t`perfect recordings`, run.n_perfect === null ? t`none` : whole(run.n_perfect)],
    [t`version of Tril`, run.versions.tril ?? t`none`],
    ...valueRows(run.recipe_values)
      .filter(({ section }) => section !== "")
      .map(({ section, name, value }) => [`${section}: ${name}`, value] as const),
  ]);
}
