/** Which runs are compared, as the address has it, and how each is drawn. */
import type { Run } from "@/api/types";

export const MOST_COMPARED = 10;

/** Returns the address of a comparison. */
export function comparePath(runIds: Iterable<string>): string {
  const search = new URLSearchParams([...runIds].map((id) => ["run", id]));
  return `/runs/compare?${search.toString()}`;
}

/** Reads the ids of an address, each once and at most ten. */
export function comparedIds(search: URLSearchParams): readonly string[] {
  return [...new Set(search.getAll("run"))].slice(0, MOST_COMPARED);
}

/** Runs that differ by their training seed only, drawn as one line. */
export interface SeedGroup {
  readonly runs: readonly Run[];
  readonly colour: string;
  readonly dashed: boolean;
}

const COLOURS = 5;

/** Groups runs by everything but the training seed, in their order, and gives each group a line. */
export function seedGroups(runs: readonly Run[]): readonly SeedGroup[] {
  const byRest = new Map<string, Run[]>();
  for (const run of runs) {
    const rest = besidesSeed(run);
    byRest.set(rest, [...(byRest.get(rest) ?? []), run]);
  }
  return [...byRest.values()].map((group, index) => ({
    runs: group,
    colour: `var(--run-${(index % COLOURS) + 1})`,
    dashed: index >= COLOURS,
  }));
}

function besidesSeed(run: Run): string {
  return JSON.stringify([
    run.behaviour_id,
    run.recipe,
    run.recipe_values,
    run.steps,
    run.go_on_anyway,
    run.example,
    run.parent_run_id,
    run.ranking_revision,
  ]);
}
