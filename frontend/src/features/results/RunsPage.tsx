import { plural, t } from "@lingui/core/macro";
import { Plural, Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { useState } from "react";
import { useSearchParams } from "react-router";

import { runsQuery } from "@/api/runs";
import type { Behaviour, Run } from "@/api/types";
import { Button, ButtonLink } from "@/components/controls/Button";
import { Empty, Failed, Loading } from "@/components/feedback/States";
import { comparePath } from "@/features/results/compare/compared-runs";
import {
  ALL_RUNS,
  filteredRuns,
  readRunsFilter,
  type RunsFilter,
  writeRunsFilter,
} from "@/features/results/list/runs-filter";
import { RunsFilterBar } from "@/features/results/list/RunsFilterBar";
import { RunsTable } from "@/features/results/list/RunsTable";

import { useGame } from "@/games/game";
import styles from "./RunsPage.module.css";

/** The runs of a behaviour, with filters kept in the address. */
export function RunsPage({ behaviour }: { behaviour: Behaviour }) {
  const { picture_url: picture } = useGame();
  const { data: runs, error, refetch } = useQuery(runsQuery(behaviour.id));
  if (error && !runs) {
    return <Failed what={t`The runs`} error={error} onRetry={() => void refetch()} />;
  }
  if (!runs) return <Loading what={t`the runs`} rows={3} height="3rem" />;
  if (runs.length === 0) {
    return (
      <Empty
        title={t`Nothing trained yet`}
        picture={picture}
        actions={
          <ButtonLink kind="primary" to={trainPath(behaviour)}>
            <Trans>Go to Train</Trans>
          </ButtonLink>
        }
      >
        <p>
          <Trans>What a run learns from your ranking appears here as it trains.</Trans>
        </p>
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
  const [selected, setSelected] = useState<readonly string[]>([]);
  const compared = selected.filter((id) => runs.some((run) => run.id === id));
  const select = (runId: string, isSelected: boolean) =>
    setSelected(isSelected ? [...compared, runId] : compared.filter((id) => id !== runId));
  const change = (next: RunsFilter) => setSearch(writeRunsFilter(next), { replace: true });
  return (
    <>
      <div className={styles.bar}>
        <h2>
          <span role="status">
            {shown.length === runs.length
              ? plural(runs.length, { one: "# run", other: "# runs" })
              : t`${shown.length} of ${plural(runs.length, { one: "# run", other: "# runs" })}`}
          </span>
        </h2>
        <div className={styles.actions}>
          {compared.length > 1 && (
            <ButtonLink kind="primary" to={comparePath(compared)}>
              <Trans>
                Compare <Plural value={compared.length} one="# run" other="# runs" />
              </Trans>
            </ButtonLink>
          )}
          {compared.length === 1 && (
            <p role="status">
              <Trans>Tick one more to compare.</Trans>
            </p>
          )}
          <ButtonLink to={trainPath(behaviour)}>
            <Trans>New run</Trans>
          </ButtonLink>
        </div>
      </div>
      <RunsFilterBar
        filter={filter}
        recipes={runs.map(({ recipe }) => recipe)}
        hasTarget={behaviour.target !== null}
        onChange={change}
      />
      {shown.length > 0 ? (
        <RunsTable
          runs={shown}
          behaviour={behaviour}
          selected={new Set(compared)}
          onSelect={select}
        />
      ) : (
        <p className={styles.none}>
          <Trans>
            No run matches the filters.{" "}
            <Button onClick={() => change({ ...ALL_RUNS, order: filter.order })}>Show all</Button>
          </Trans>
        </p>
      )}
    </>
  );
}
