/** The filter and order of a list of runs, and how the address encodes them. */
import type { Run } from "@/api/types";
import { isActive, runName, shortId } from "@/lib/runs";

export const STATES = ["active", "done", "stopped", "failed", "cancelled"] as const;
export const ORDERS = ["newest", "oldest", "name", "targets", "deaths", "steps"] as const;

export interface RunsFilter {
  readonly state: (typeof STATES)[number] | null;
  readonly recipe: string | null;
  /** Words of which each is in the name, the notes or the recipe; "" for any. */
  readonly q: string;
  readonly order: (typeof ORDERS)[number];
}

export const ALL_RUNS: RunsFilter = { state: null, recipe: null, q: "", order: "newest" };

/** Reads the filter from an address, ignoring invalid values. */
export function readRunsFilter(search: URLSearchParams): RunsFilter {
  return {
    state: STATES.find((one) => one === search.get("state")) ?? null,
    recipe: search.get("recipe"),
    q: search.get("q") ?? "",
    order: ORDERS.find((one) => one === search.get("order")) ?? ALL_RUNS.order,
  };
}

/** Encodes a filter for an address, omitting defaults. */
export function writeRunsFilter({ state, recipe, q, order }: RunsFilter): URLSearchParams {
  const search = new URLSearchParams();
  if (state !== null) search.set("state", state);
  if (recipe !== null) search.set("recipe", recipe);
  if (q.trim()) search.set("q", q);
  if (order !== ALL_RUNS.order) search.set("order", order);
  return search;
}

/** Whether a filter excludes anything. */
export function isNarrow(filter: RunsFilter): boolean {
  return writeRunsFilter({ ...filter, order: ALL_RUNS.order }).size > 0;
}

/** Returns the runs that match a filter, in its order. */
export function filteredRuns(runs: readonly Run[], filter: RunsFilter): Run[] {
  const words = filter.q.toLowerCase().split(/\s+/).filter(Boolean);
  return runs.filter((run) => fits(run, filter, words)).sort(COMPARE[filter.order]);
}

function fits(run: Run, { state, recipe }: RunsFilter, words: readonly string[]): boolean {
  if (state !== null && (state === "active" ? !isActive(run) : run.status !== state)) return false;
  if (recipe !== null && run.recipe !== recipe) return false;
  const text = [run.name, shortId(run.id), run.notes, run.recipe].join("\n").toLowerCase();
  return words.every((word) => text.includes(word));
}

type Compare = (a: Run, b: Run) => number;

const newest: Compare = (a, b) =>
  Date.parse(b.created_at) - Date.parse(a.created_at) || a.id.localeCompare(b.id);

/** Runs without the value come last. */
function by(value: (run: Run) => number | undefined): Compare {
  return (a, b) => {
    const [one, other] = [value(a) ?? Infinity, value(b) ?? Infinity];
    return one === other ? newest(a, b) : one - other;
  };
}

const COMPARE: Readonly<Record<RunsFilter["order"], Compare>> = {
  newest,
  oldest: (a, b) => newest(b, a),
  name: (a, b) =>
    runName(a).localeCompare(runName(b), undefined, { numeric: true }) || newest(a, b),
  targets: by((run) => negated(run.headline?.imitator?.targets?.mean)),
  deaths: by((run) => run.headline?.imitator?.death_rate.mean),
  steps: by((run) => -run.steps),
};

function negated(value: number | undefined): number | undefined {
  return value === undefined ? undefined : -value;
}
