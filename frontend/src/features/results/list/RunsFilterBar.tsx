import { Filters, Search, Select } from "@/components/controls/Filters";

import { ALL_RUNS, isNarrow, ORDERS, type RunsFilter, STATES } from "./runs-filter";

const ANY = "";
const STATE_NAMES = {
  active: "Waiting or running",
  done: "Done",
  stopped: "Stopped by the check",
  failed: "Failed",
  cancelled: "Cancelled",
} as const;
const ORDER_NAMES: Readonly<Record<RunsFilter["order"], string>> = {
  newest: "Newest first",
  oldest: "Oldest first",
  name: "By name",
  targets: "Most targets first",
  deaths: "Lowest death rate first",
  steps: "Most steps first",
};

interface RunsFilterBarProps {
  filter: RunsFilter;
  /** The recipes of the runs there are. */
  recipes: readonly string[];
  hasTarget: boolean;
  onChange: (filter: RunsFilter) => void;
}

/** Searches, filters and sorts the runs. */
export function RunsFilterBar({ filter, recipes, hasTarget, onChange }: RunsFilterBarProps) {
  const set = (change: Partial<RunsFilter>) => onChange({ ...filter, ...change });
  const offered = [...new Set([...recipes, ...(filter.recipe === null ? [] : [filter.recipe])])];
  return (
    <Filters
      label="Filter the runs"
      role="search"
      onClear={isNarrow(filter) ? () => onChange({ ...ALL_RUNS, order: filter.order }) : undefined}
    >
      <Search label="Search name, notes or recipe" value={filter.q} onChange={(q) => set({ q })} />
      <Select
        label="State"
        value={filter.state ?? ANY}
        options={[[ANY, "Any"], ...STATES.map((one) => [one, STATE_NAMES[one]] as const)]}
        onChange={(state) => set({ state: state === ANY ? null : state })}
      />
      <Select
        label="Recipe"
        value={filter.recipe ?? ANY}
        options={[[ANY, "Any"], ...offered.sort().map((one) => [one, one] as const)]}
        onChange={(recipe) => set({ recipe: recipe === ANY ? null : recipe })}
      />
      <Select
        label="Order"
        value={filter.order}
        options={ORDERS.filter((one) => hasTarget || one !== "targets").map((one) => [
          one,
          ORDER_NAMES[one],
        ])}
        onChange={(order) => set({ order })}
      />
    </Filters>
  );
}
