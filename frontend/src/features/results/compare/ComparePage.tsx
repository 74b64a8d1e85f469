import { plural, t } from "@lingui/core/macro";
import { Plural, Trans } from "@lingui/react/macro";
import { useQueries, useQuery } from "@tanstack/react-query";
import { Link, useSearchParams } from "react-router";

import { behaviourQuery } from "@/api/behaviours";
import { runQuery } from "@/api/runs";
import type { Run } from "@/api/types";
import { Empty, Failed, Loading, Notice } from "@/components/feedback/States";
import { PageTitle } from "@/components/PageTitle";

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
    return <Loading what={t`the runs`} rows={3} height="6rem" />;
  }
  if (runs.length === 0) {
    const [first] = queries;
    if (first?.error) return <Failed what={t`The runs`} error={first.error} />;
    return (
      <Empty level="h1" title={t`Nothing to compare`}>
        <p>
          <Trans>
            Select runs in a behaviour&rsquo;s list of runs, and compare them from there.
          </Trans>
        </p>
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
      <PageTitle>{t`${plural(runs.length, { one: "# run", other: "# runs" })} compared · Tril`}</PageTitle>
      <h1>
        <Trans>
          <Plural value={runs.length} one="# run" other="# runs" /> compared
        </Trans>
      </h1>
      {behaviour && (
        <p className={styles.note}>
          <Link to={`/behaviours/${behaviour.id}/runs`}>
            <Trans>All runs of {behaviour.name}</Trans>
          </Link>
        </p>
      )}
      {missing > 0 && (
        <Notice>
          <p>
            <Plural
              value={missing}
              one="# run could not be loaded, or was deleted."
              other="# runs could not be loaded, or were deleted."
            />
          </p>
        </Notice>
      )}
      <section className={styles.section} aria-label={t`Results and settings`}>
        <ComparedTable runs={runs} groups={groups} nTargets={shared?.target?.length ?? null} />
        <p className={styles.note}>
          <Trans>
            Means of greedy games from starts that training never used, with 95% bootstrap
            intervals. Where intervals overlap widely, the runs can&rsquo;t be told apart.
          </Trans>
        </p>
      </section>
      <ComparedCurves groups={groups} />
    </div>
  );
}
