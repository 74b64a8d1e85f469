import { t } from "@lingui/core/macro";

import { Filters, Search, Select } from "@/components/controls/Filters";

import { ALL_RUNS, isNarrow, ORDERS, type RunsFilter, STATES } from "./runs-filter";

const ANY = "";
const stateNames = () =>
  ({
    active: t`Waiting or running`,
    done: t`Done`,
    stopped: t`Stopped by the check`,
    failed: t`Failed`,
    cancelled: t`Cancelled`,
  }) as const;
const orderNames = (): Readonly<Record<RunsFilter["order"], string>> => ({
  newest: t`Newest first`,
  oldest: t`Oldest first`,
  name: t`By name`,
  targets: t`Most targets first`,
  deaths: t`Lowest death rate first`,
  steps: t`Most steps first`,
});

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
      label={t`Filter the runs`}
      role="search"
      folds
      onClear={isNarrow(filter) ? () => onChange({ ...ALL_RUNS, order: filter.order }) : undefined}
    >
      <Search
        label={t`Search name, notes or recipe`}
        value={filter.q}
        onChange={(q) => set({ q })}
      />
      <Select
        label={t`State`}
        value={filter.state ?? ANY}
        options={[[ANY, t`Any`], ...STATES.map((one) => [one, stateNames()[one]] as const)]}
        onChange={(state) => set({ state: state === ANY ? null : state })}
      />
      <Select
        label={t`Recipe`}
        value={filter.recipe ?? ANY}
        options={[[ANY, t`Any`], ...offered.sort().map((one) => [one, one] as const)]}
        onChange={(recipe) => set({ recipe: recipe === ANY ? null : recipe })}
      />
      <Select
        label={t`Order`}
        value={filter.order}
        options={ORDERS.filter((one) => hasTarget || one !== "targets").map((one) => [
          one,
          orderNames()[one],
        ])}
        onChange={(order) => set({ order })}
      />
    </Filters>
  );
}
