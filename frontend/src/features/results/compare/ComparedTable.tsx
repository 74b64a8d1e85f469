import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import type { CSSProperties } from "react";
import { Link } from "react-router";

import type { Interval, Run } from "@/api/types";
import { IntervalPlot } from "@/features/results/games/IntervalPlot";
import { RunStatus } from "@/features/results/RunStatus";
import { classes } from "@/lib/classes";
import { NONE } from "@/lib/format";
import { runName } from "@/lib/runs";

import { differenceRows, resultRows } from "./compared-rows";
import type { SeedGroup } from "./compared-runs";
import styles from "./ComparedTable.module.css";

const policies = () =>
  [
    ["imitator", t`Imitator`],
    ["clone", t`Clone`],
  ] as const;

interface ComparedTableProps {
  runs: readonly Run[];
  groups: readonly SeedGroup[];
  nTargets: number | null;
}

/** A column for each run: results of imitator and clone, and the settings that differ. */
export function ComparedTable({ runs, groups, nTargets }: ComparedTableProps) {
  const differences = differenceRows(runs);
  const groupOf = (run: Run) => groups.find((group) => group.runs.includes(run));
  const results = policies()
    .map(([policy, title]) => ({
      policy,
      title,
      rows: resultRows(runs, policy, nTargets),
    }))
    .filter(({ rows }) => rows.length > 0);
  return (
    // Scrolls horizontally; focusable so that the keyboard can scroll it.
    // eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex
    <div className={styles.scroll} role="region" aria-label={t`Runs side by side`} tabIndex={0}>
      <table
        className={styles.table}
        style={{ "--runs": runs.length } as CSSProperties}
        aria-label={t`Runs side by side`}
      >
        <thead>
          <tr>
            <td />
            {runs.map((run) => (
              <th key={run.id} scope="col">
                <Line group={groupOf(run)} />
                <Link to={`/runs/${run.id}`}>{runName(run)}</Link>
                {run.status !== "done" && (
                  <span className={styles.bounds}>
                    <RunStatus run={run} />
                  </span>
                )}
              </th>
            ))}
          </tr>
        </thead>
        {results.map(({ policy, title, rows }) => (
          <tbody key={policy}>
            <Part name={title} nRuns={runs.length} />
            {rows.map(({ name, cells, write, high }) => (
              <tr key={name}>
                <th scope="row">{name}</th>
                {runs.map((run, index) => (
                  <ValueCell
                    key={run.id}
                    interval={cells[index] ?? null}
                    write={write}
                    high={high}
                    actor={policy}
                    colour={groupOf(run)?.colour}
                  />
                ))}
              </tr>
            ))}
          </tbody>
        ))}
        <tbody>
          <Part
            name={differences.length > 0 ? t`Settings that differ` : t`All settings are the same`}
            nRuns={runs.length}
          />
          {differences.map(({ name, cells }) => (
            <tr key={name}>
              <th scope="row">{name}</th>
              {cells.map((value, index) => (
                <td key={runs[index]?.id}>{value}</td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

function Part({ name, nRuns }: { name: string; nRuns: number }) {
  return (
    <tr>
      <th scope="rowgroup" className={styles.part}>
        {name}
      </th>
      <td colSpan={nRuns} />
    </tr>
  );
}

/** The line by which the charts draw a run. */
function Line({ group }: { group: SeedGroup | undefined }) {
  if (!group) return null;
  return (
    <i
      className={classes(styles.line, group.dashed && styles.dashed)}
      style={{ "--curve": group.colour } as CSSProperties}
      aria-hidden="true"
    />
  );
}

/** A mean and its interval, which is drawn below in the colour of the run's line. */
function ValueCell({
  interval,
  write,
  high,
  actor,
  colour,
}: {
  interval: Interval | null;
  write: (value: number) => string;
  high: number;
  actor: "imitator" | "clone";
  colour: string | undefined;
}) {
  if (!interval) return <td>{NONE}</td>;
  return (
    <td>
      <span className={styles.value}>
        <b>{write(interval.mean)}</b>
        <span className={styles.bounds}>
          <Trans>
            {write(interval.low)} to {write(interval.high)}
          </Trans>
        </span>
      </span>
      <IntervalPlot low={0} high={high} intervals={[{ actor, interval, colour }]} />
    </td>
  );
}
