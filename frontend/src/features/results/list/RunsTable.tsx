import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { Link } from "react-router";

import type { Behaviour, Interval, Run } from "@/api/types";
import { useFirst } from "@/components/list/use-first";
import { ActorMark } from "@/components/game/ActorMark";
import { RunName } from "@/components/RunName";
import { Ago } from "@/features/results/Ago";
import { IntervalPlot } from "@/features/results/games/IntervalPlot";
import { MOST_COMPARED } from "@/features/results/compare/compared-runs";
import { RunStatus } from "@/features/results/RunStatus";
import { useMedia } from "@/lib/browser/use-media";
import { duration, fixed, NONE, percent, shortCount, wholeShare } from "@/lib/format";
import { isActive, queuePlace, runName, shortId, statusLine } from "@/lib/runs";

import styles from "./RunsTable.module.css";

/** A phone, where the state has no column: see RunsTable.module.css. */
const NARROW = "(max-width: 34rem)";

interface RunsTableProps {
  runs: readonly Run[];
  behaviour: Behaviour;
  /** Ids of the runs to compare. */
  selected: ReadonlySet<string>;
  onSelect: (runId: string, isSelected: boolean) => void;
}

/** Runs in a table of parameters and results. */
export function RunsTable({ runs, behaviour, selected, onSelect }: RunsTableProps) {
  const of = behaviour.target?.length;
  const narrow = useMedia(NARROW);
  const [shown, more] = useFirst(runs);
  return (
    // Scrolls horizontally on a phone; focusable so that the keyboard can scroll it.
    // eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex
    <div className={styles.scroll} role="region" aria-label={t`Runs`} tabIndex={0}>
      <table className={styles.table} aria-label={t`Runs`}>
        <thead>
          <tr>
            <th scope="col">
              <span className="visually-hidden">
                <Trans>Compare</Trans>
              </span>
            </th>
            <th scope="col">
              <Trans>Run</Trans>
            </th>
            {!narrow && (
              <th scope="col">
                <Trans>State</Trans>
              </th>
            )}
            {of !== undefined && (
              <>
                <th scope="col">
                  <ActorMark actor="imitator">
                    <Trans>Imitator, targets of {of}</Trans>
                  </ActorMark>
                </th>
                <th scope="col">
                  <ActorMark actor="clone">
                    <Trans>Clone, targets of {of}</Trans>
                  </ActorMark>
                </th>
                <th scope="col" className={styles.right}>
                  <Trans>Strays</Trans>
                </th>
              </>
            )}
            {of === undefined && (
              <th scope="col">
                <ActorMark actor="imitator">
                  <abbr
                    title={t`Worth of the imitator’s games by what Tril understood, of a full game`}
                  >
                    <Trans>Worth</Trans>
                  </abbr>
                </ActorMark>
              </th>
            )}
            <th scope="col" className={styles.right}>
              <Trans>Death rate</Trans>
            </th>
            <th scope="col" className={styles.right}>
              <abbr title={t`Agreement of the learned reward with the ranking, 1 at most`}>
                <Trans>Tau</Trans>
              </abbr>
            </th>
            <th scope="col">
              <Trans>Recipe</Trans>
            </th>
            <th scope="col" className={styles.right}>
              <Trans>Steps</Trans>
            </th>
            <th scope="col" className={styles.right}>
              <Trans>Seed</Trans>
            </th>
            <th scope="col" className={styles.right}>
              <Trans>Ranked</Trans>
            </th>
            <th scope="col" className={styles.right}>
              <Trans>Took</Trans>
            </th>
            <th scope="col">
              <Trans>Created</Trans>
            </th>
          </tr>
        </thead>
        <tbody>
          {shown.map((run) => (
            <RunRow
              key={run.id}
              run={run}
              nTargets={of}
              narrow={narrow}
              isSelected={selected.has(run.id)}
              isFull={selected.size >= MOST_COMPARED}
              onSelect={onSelect}
            />
          ))}
        </tbody>
      </table>
      {more}
    </div>
  );
}

interface RunRowProps {
  run: Run;
  /** Number of targets of the behaviour, if it has any. */
  nTargets: number | undefined;
  /** Whether the state stands below the name. */
  narrow: boolean;
  isSelected: boolean;
  isFull: boolean;
  onSelect: RunsTableProps["onSelect"];
}

function RunRow({ run, nTargets, narrow, isSelected, isFull, onSelect }: RunRowProps) {
  const imitator = run.headline?.imitator;
  const tau = run.headline?.tau ?? null;
  return (
    <tr>
      <td>
        <label className={styles.select}>
          <input
            type="checkbox"
            aria-label={t`Compare ${runName(run)}`}
            checked={isSelected}
            disabled={isFull && !isSelected}
            onChange={(event) => onSelect(run.id, event.currentTarget.checked)}
          />
        </label>
      </td>
      <th scope="row">
        <Link to={`/runs/${run.id}`} title={runName(run)}>
          {runName(run)}
        </Link>
        {narrow && (
          <span className={styles.state}>
            <State run={run} />
          </span>
        )}
        {run.name && <span className={styles.bounds}>{shortId(run.id)}</span>}
        {run.notes && (
          <span className={styles.notes} title={run.notes}>
            {run.notes}
          </span>
        )}
        {run.example && (
          <span className={styles.bounds}>
            <Trans>scripted example</Trans>
          </span>
        )}
        {run.parent_run_id !== null && (
          <span className={styles.bounds}>
            <Trans>
              continues <RunName id={run.parent_run_id} />
            </Trans>
          </span>
        )}
      </th>
      {!narrow && (
        <td>
          <State run={run} />
        </td>
      )}
      {nTargets !== undefined && (
        <>
          <IntervalCell actor="imitator" interval={imitator?.targets} high={nTargets} />
          <IntervalCell actor="clone" interval={run.headline?.clone?.targets} high={nTargets} />
          <td className={styles.right}>
            {imitator?.strays ? fixed(imitator.strays.mean, 1) : NONE}
          </td>
        </>
      )}
      {nTargets === undefined && (
        <IntervalCell
          actor="imitator"
          interval={run.headline?.understood?.imitator}
          high={1}
          write={wholeShare}
        />
      )}
      <td className={styles.right}>{imitator ? percent(imitator.death_rate.mean, 0) : NONE}</td>
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

function State({ run }: { run: Run }) {
  return (
    <>
      <RunStatus run={run} />
      {isActive(run) && (
        <span className={styles.bounds}>
          {run.queue_position === null ? statusLine(run) : queuePlace(run.queue_position)}
        </span>
      )}
    </>
  );
}

/** A mean with its interval, and both on an axis from 0. */
function IntervalCell({
  actor,
  interval,
  high,
  write = oneDigit,
}: {
  actor: "imitator" | "clone";
  interval: Interval | null | undefined;
  high: number;
  write?: (value: number) => string;
}) {
  if (!interval) return <td>{NONE}</td>;
  return (
    <td>
      <span className={styles.value}>
        <b>{write(interval.mean)}</b>
        <span
          className={styles.bounds}
        >{t`${write(interval.low)} to ${write(interval.high)}`}</span>
      </span>
      <IntervalPlot low={0} high={high} intervals={[{ actor, interval }]} />
    </td>
  );
}

function tookOf({ started_at: started, finished_at: finished }: Run): string {
  if (!started || !finished) return NONE;
  return duration((Date.parse(finished) - Date.parse(started)) / 1000);
}

const oneDigit = (value: number) => fixed(value, 1);
