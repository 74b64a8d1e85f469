/** The rows of the table that compares runs; every row has a cell for each run. */
import type { Interval, PolicySummary, Run } from "@/api/types";
import { fixed, percent, whole } from "@/lib/format";
import { valueRows } from "@/lib/recipe-values";
import { shortId } from "@/lib/runs";

export interface ResultRow {
  readonly name: string;
  readonly cells: readonly (Interval | null)[];
  readonly write: (value: number) => string;
}

const oneDigit = (value: number) => fixed(value, 1);
const wholePercent = (value: number) => percent(value, 0);

const MEASURES: readonly {
  readonly key: keyof PolicySummary;
  readonly name: string;
  readonly write: (value: number) => string;
}[] = [
  { key: "targets", name: "Targets hit", write: oneDigit },
  { key: "strays", name: "Strays", write: oneDigit },
  { key: "death_rate", name: "Death rate", write: wholePercent },
  { key: "perfect", name: "Perfect games", write: wholePercent },
];

/** Returns a policy's results in greedy games, without measures that no run has. */
export function resultRows(
  runs: readonly Run[],
  policy: "imitator" | "clone",
  nTargets: number | null,
): readonly ResultRow[] {
  return MEASURES.map(({ key, name, write }) => ({
    name: key === "targets" && nTargets !== null ? `${name}, of ${nTargets}` : name,
    write,
    cells: runs.map((run) => run.headline?.[policy]?.[key] ?? null),
  })).filter(({ cells }) => cells.some((cell) => cell !== null));
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
    .map((name) => ({ name, cells: settings.map((one) => one.get(name) ?? "none") }))
    .filter(({ cells }) => new Set(cells).size > 1);
}

function settingsOf(run: Run): ReadonlyMap<string, string> {
  const parent = run.parent_run_id;
  return new Map([
    ["behaviour", run.behaviour_name],
    ["recipe", run.recipe],
    ["steps", whole(run.steps)],
    ["training seed", String(run.training_seed)],
    ["go on anyway", run.go_on_anyway ? "yes" : "no"],
    ["continues", parent === null ? "none" : shortId(parent)],
    ["ranking revision", run.ranking_revision === null ? "none" : whole(run.ranking_revision)],
    ["ranked recordings", run.n_ranked === null ? "none" : whole(run.n_ranked)],
    ["perfect recordings", run.n_perfect === null ? "none" : whole(run.n_perfect)],
    ["version of Tril", run.versions.tril ?? "none"],
    ...valueRows(run.recipe_values)
      .filter(({ section }) => section !== "")
      .map(({ section, name, value }) => [`${section}: ${name}`, value] as const),
  ]);
}
