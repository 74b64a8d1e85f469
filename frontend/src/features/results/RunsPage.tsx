import { useQuery } from "@tanstack/react-query";
import { Link } from "react-router";

import { runsQuery } from "@/api/runs";
import type { Behaviour, Interval, Run } from "@/api/types";
import { ButtonLink } from "@/components/controls/Button";
import { Empty, Failed, Loading } from "@/components/feedback/States";
import { ThingMark } from "@/components/game/ThingMark";
import { bounds, count, duration, fixed, NONE, shortCount } from "@/lib/format";
import { isActive, runName, statusLine } from "@/lib/runs";

import { Ago } from "./Ago";
import { RunStatus } from "./RunStatus";
import styles from "./RunsPage.module.css";

/** The runs of a behaviour in a table of parameters and results. */
export function RunsPage({ behaviour }: { behaviour: Behaviour }) {
  const { data: runs, error, refetch } = useQuery(runsQuery(behaviour.id));
  if (error && !runs) {
    return <Failed what="The runs" error={error} onRetry={() => void refetch()} />;
  }
  if (!runs) return <Loading what="the runs" rows={3} height="3rem" />;
  const train = `/behaviours/${behaviour.id}/train`;
  if (runs.length === 0) {
    return (
      <Empty
        title="Nothing trained yet"
        actions={
          <ButtonLink kind="primary" to={train}>
            Go to Train
          </ButtonLink>
        }
      >
        <p>What a run learns from your ranking appears here as it trains.</p>
      </Empty>
    );
  }
  return (
    <>
      <div className={styles.bar}>
        <h2>{count(runs.length, "run")}</h2>
        <ButtonLink to={train}>New run</ButtonLink>
      </div>
      {/* Scrolls horizontally on a phone; focusable so that the keyboard can scroll it. */}
      {/* eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex */}
      <div className={styles.scroll} role="region" aria-label="Runs" tabIndex={0}>
        <RunsTable runs={runs} behaviour={behaviour} />
      </div>
    </>
  );
}

function RunsTable({ runs, behaviour }: { runs: readonly Run[]; behaviour: Behaviour }) {
  const of = behaviour.target?.length;
  return (
    <table className={styles.table} aria-label="Runs">
      <thead>
        <tr>
          <th scope="col">Run</th>
          <th scope="col">State</th>
          {of !== undefined && (
            <>
              <th scope="col">
                <ThingMark thing="imitator">Imitator, targets of {of}</ThingMark>
              </th>
              <th scope="col">
                <ThingMark thing="clone">Clone, targets of {of}</ThingMark>
              </th>
              <th scope="col" className={styles.right}>
                Strays
              </th>
            </>
          )}
          <th scope="col" className={styles.right}>
            Death rate
          </th>
          <th scope="col" className={styles.right}>
            Tau
          </th>
          <th scope="col">Recipe</th>
          <th scope="col" className={styles.right}>
            Steps
          </th>
          <th scope="col" className={styles.right}>
            Seed
          </th>
          <th scope="col" className={styles.right}>
            Ranked
          </th>
          <th scope="col" className={styles.right}>
            Took
          </th>
          <th scope="col">Created</th>
        </tr>
      </thead>
      <tbody>
        {runs.map((run) => (
          <RunRow key={run.id} run={run} hasTarget={of !== undefined} />
        ))}
      </tbody>
    </table>
  );
}

function RunRow({ run, hasTarget }: { run: Run; hasTarget: boolean }) {
  const imitator = run.headline?.imitator;
  const tau = run.headline?.tau ?? null;
  return (
    <tr>
      <th scope="row">
        <Link to={`/runs/${run.id}`}>{runName(run)}</Link>
        {run.example && <span className={styles.bounds}>scripted example</span>}
        {run.parent_run_id !== null && (
          <span className={styles.bounds}>
            continues {runName({ id: run.parent_run_id }).toLowerCase()}
          </span>
        )}
      </th>
      <td>
        <RunStatus run={run} />
        {isActive(run) && <span className={styles.bounds}>{statusLine(run)}</span>}
      </td>
      {hasTarget && (
        <>
          <IntervalCell interval={imitator?.targets} />
          <IntervalCell interval={run.headline?.clone?.targets} />
          <td className={styles.right}>
            {imitator?.strays ? fixed(imitator.strays.mean, 1) : NONE}
          </td>
        </>
      )}
      <td className={styles.right}>
        {imitator ? `${fixed(imitator.death_rate.mean * 100, 0)}%` : NONE}
      </td>
      <td className={styles.right}>{tau === null ? NONE : fixed(tau, 2)}</td>
      <td>{run.recipe}</td>
      <td className={styles.right}>{shortCount(run.steps)}</td>
      <td className={styles.right}>{run.training_seed}</td>
      <td className={styles.right}>{run.n_ranked ?? NONE}</td>
      <td className={styles.right}>{tookOf(run)}</td>
      <td className={styles.dim}>
        <Ago time={run.created_at} />
      </td>
    </tr>
  );
}

function IntervalCell({ interval }: { interval: Interval | null | undefined }) {
  if (!interval) return <td>{NONE}</td>;
  return (
    <td>
      {fixed(interval.mean, 1)}
      <span className={styles.bounds}>{bounds(interval)}</span>
    </td>
  );
}

function tookOf({ started_at: started, finished_at: finished }: Run): string {
  if (!started || !finished) return NONE;
  return duration((Date.parse(finished) - Date.parse(started)) / 1000);
}
