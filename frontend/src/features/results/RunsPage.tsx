import { useQuery } from "@tanstack/react-query";
import { useSearchParams } from "react-router";

import { runsQuery } from "@/api/runs";
import type { Behaviour, Run } from "@/api/types";
import { Button, ButtonLink } from "@/components/controls/Button";
import { Empty, Failed, Loading } from "@/components/feedback/States";
import {
  ALL_RUNS,
  filteredRuns,
  readRunsFilter,
  type RunsFilter,
  writeRunsFilter,
} from "@/features/results/list/runs-filter";
import { RunsFilterBar } from "@/features/results/list/RunsFilterBar";
import { RunsTable } from "@/features/results/list/RunsTable";
import { count } from "@/lib/format";

import styles from "./RunsPage.module.css";

/** The runs of a behaviour, with filters kept in the address. */
export function RunsPage({ behaviour }: { behaviour: Behaviour }) {
  const { data: runs, error, refetch } = useQuery(runsQuery(behaviour.id));
  if (error && !runs) {
    return <Failed what="The runs" error={error} onRetry={() => void refetch()} />;
  }
  if (!runs) return <Loading what="the runs" rows={3} height="3rem" />;
  if (runs.length === 0) {
    return (
      <Empty
        title="Nothing trained yet"
        actions={
          <ButtonLink kind="primary" to={trainPath(behaviour)}>
            Go to Train
          </ButtonLink>
        }
      >
        <p>What a run learns from your ranking appears here as it trains.</p>
      </Empty>
    );
  }
  return <Runs runs={runs} behaviour={behaviour} />;
}

function trainPath({ id }: Behaviour): string {
  return `/behaviours/${id}/train`;
}

function Runs({ runs, behaviour }: { runs: readonly Run[]; behaviour: Behaviour }) {
  const [search, setSearch] = useSearchParams();
  const filter = readRunsFilter(search);
  const shown = filteredRuns(runs, filter);
  const change = (next: RunsFilter) => setSearch(writeRunsFilter(next), { replace: true });
  return (
    <>
      <div className={styles.bar}>
        <h2>
          <span role="status">
            {shown.length === runs.length
              ? count(runs.length, "run")
              : `${shown.length} of ${count(runs.length, "run")}`}
          </span>
        </h2>
        <ButtonLink to={trainPath(behaviour)}>New run</ButtonLink>
      </div>
      <RunsFilterBar
        filter={filter}
        recipes={runs.map(({ recipe }) => recipe)}
        hasTarget={behaviour.target !== null}
        onChange={change}
      />
      {shown.length > 0 ? (
        <RunsTable runs={shown} behaviour={behaviour} />
      ) : (
        <p className={styles.none}>
          No run matches the filters.{" "}
          <Button onClick={() => change({ ...ALL_RUNS, order: filter.order })}>Show all</Button>
        </p>
      )}
    </>
  );
}
