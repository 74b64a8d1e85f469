import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { type ReactNode } from "react";
import { Link, useSearchParams } from "react-router";

import { runsQuery } from "@/api/runs";
import type { Behaviour, Run } from "@/api/types";
import { moment } from "@/lib/format";
import { runName } from "@/lib/runs";

import styles from "./RewardRun.module.css";

interface RewardRun {
  /** The run whose reward model is shown; null if there is none. */
  readonly runId: string | null;
  /** The menu of runs, or what to do where there is none. */
  readonly control: ReactNode;
}

/** The name of the run in the address, so that a moment can be linked to with its reward. */
const PARAMETER = "run";

/** Chooses a finished run of a behaviour, the newest unless the address names another. */
export function useRewardRun(behaviour: Behaviour): RewardRun {
  const { data: runs } = useQuery(runsQuery(behaviour.id));
  const [search, setSearch] = useSearchParams();
  if (!runs) return { runId: null, control: null };
  const finished = runs.filter(({ status }) => status === "done");
  const chosen = finished.find(({ id }) => id === search.get(PARAMETER)) ?? finished[0];
  if (!chosen) return { runId: null, control: <NoReward behaviour={behaviour} runs={runs} /> };
  const choose = (runId: string) =>
    setSearch(
      (before) => {
        before.set(PARAMETER, runId);
        return before;
      },
      { replace: true, preventScrollReset: true },
    );
  return {
    runId: chosen.id,
    control: <RunMenu runs={finished} chosen={chosen} onChoose={choose} />,
  };
}

function RunMenu({
  runs,
  chosen,
  onChoose,
}: {
  runs: readonly Run[];
  chosen: Run;
  onChoose: (runId: string) => void;
}) {
  return (
    <label className={styles.menu}>
      <span className="visually-hidden">
        <Trans>Reward model of</Trans>
      </span>
      <select value={chosen.id} onChange={(event) => onChoose(event.currentTarget.value)}>
        {runs.map((run, index) => (
          <option key={run.id} value={run.id}>
            {runName(run)}, {run.recipe}, {moment(run.created_at)}
            {index === 0 && runs.length > 1 ? ` (${t`newest`})` : ""}
          </option>
        ))}
      </select>
    </label>
  );
}

function NoReward({ behaviour, runs }: { behaviour: Behaviour; runs: readonly Run[] }) {
  const at = `/behaviours/${behaviour.id}`;
  return (
    <p className={styles.none}>
      <Trans>
        No run of {behaviour.name} has finished yet, so there is no learned reward to show here.
      </Trans>{" "}
      {runs.length === 0 ? (
        <Link to={`${at}/train`}>
          <Trans>Train one</Trans>
        </Link>
      ) : (
        <Link to={`${at}/runs`}>
          <Trans>Look at its runs</Trans>
        </Link>
      )}
    </p>
  );
}
