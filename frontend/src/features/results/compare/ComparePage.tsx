import { useQueries, useQuery } from "@tanstack/react-query";
import { Link, useSearchParams } from "react-router";

import { behaviourQuery } from "@/api/behaviours";
import { runQuery } from "@/api/runs";
import type { Run } from "@/api/types";
import { Empty, Failed, Loading, Notice } from "@/components/feedback/States";
import { PageTitle } from "@/components/PageTitle";
import { count } from "@/lib/format";

import { comparedIds, seedGroups } from "./compared-runs";
import { ComparedCurves } from "./ComparedCurves";
import { ComparedTable } from "./ComparedTable";
import styles from "./ComparePage.module.css";

/** Up to ten runs, which the address names: results side by side, settings that differ, curves. */
export function ComparePage() {
  const [search] = useSearchParams();
  const queries = useQueries({ queries: comparedIds(search).map((id) => runQuery(id)) });
  const runs = queries.flatMap(({ data }) => data ?? []);
  const missing = queries.filter(({ error, data }) => error && !data).length;
  if (queries.some(({ isPending }) => isPending)) {
    return <Loading what="the runs" rows={3} height="6rem" />;
  }
  if (runs.length === 0) {
    const [first] = queries;
    if (first?.error) return <Failed what="The runs" error={first.error} />;
    return (
      <Empty title="Nothing to compare">
        <p>Select runs in a behaviour&rsquo;s list of runs, and compare them from there.</p>
      </Empty>
    );
  }
  return <Comparison runs={runs} missing={missing} />;
}

function Comparison({ runs, missing }: { runs: readonly Run[]; missing: number }) {
  const behaviourIds = [...new Set(runs.map((run) => run.behaviour_id))];
  const [behaviourId = 0] = behaviourIds;
  const { data: behaviour } = useQuery(behaviourQuery(behaviourId));
  const shared = behaviourIds.length === 1 ? behaviour : undefined;
  const groups = seedGroups(runs);
  return (
    <div className={styles.stack}>
      <PageTitle>{`${count(runs.length, "run")} compared · Tril`}</PageTitle>
      <h1>{count(runs.length, "run")} compared</h1>
      {behaviour && (
        <p className={styles.note}>
          <Link to={`/behaviours/${behaviour.id}/runs`}>All runs of {behaviour.name}</Link>
        </p>
      )}
      {missing > 0 && (
        <Notice>
          <p>{count(missing, "run")} could not be loaded, or was deleted.</p>
        </Notice>
      )}
      <section className={styles.section} aria-label="Results and settings">
        <ComparedTable runs={runs} groups={groups} nTargets={shared?.target?.length ?? null} />
        <p className={styles.note}>
          Means of greedy games from starts that no training game began from, with 95 % bootstrap
          intervals. Where intervals overlap widely, the runs can&rsquo;t be told apart.
        </p>
      </section>
      <ComparedCurves groups={groups} />
    </div>
  );
}
