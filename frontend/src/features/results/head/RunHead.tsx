import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useState } from "react";
import { Link } from "react-router";

import type { Behaviour, Run } from "@/api/types";
import { IconButton } from "@/components/controls/Button";
import { RunName } from "@/components/RunName";
import { Ago } from "@/features/results/Ago";
import { RunActions } from "@/features/results/run/RunActions";
import { RunStatus } from "@/features/results/RunStatus";
import { shortCount } from "@/lib/format";
import { runName, shortId } from "@/lib/runs";

import { DescribeRunDialog } from "./DescribeRunDialog";

import styles from "./RunHead.module.css";

/** The name, state, settings and notes of a run. */
export function RunHead({ run, behaviour }: { run: Run; behaviour: Behaviour }) {
  const [describing, setDescribing] = useState(false);
  return (
    <div className={styles.head}>
      <div className={styles.about}>
        <div className={styles.title}>
          <h2>{runName(run)}</h2>
          <IconButton
            icon="edit"
            label={t`Edit name and notes`}
            onClick={() => setDescribing(true)}
          />
          <RunStatus run={run} />
        </div>
        <p className={styles.facts}>
          {run.name && <span>{shortId(run.id)}</span>}
          <span>
            <Trans>{run.recipe} recipe</Trans>
          </span>
          <span>
            <Trans>{shortCount(run.steps)} steps</Trans>
          </span>
          <span>
            <Trans>training seed {run.training_seed}</Trans>
          </span>
          {run.n_ranked !== null && (
            <span>{plural(run.n_ranked, { one: "# ranked game", other: "# ranked games" })}</span>
          )}
          {run.parent_run_id !== null && (
            <span>
              <Trans>
                Continues{" "}
                <Link to={`/runs/${run.parent_run_id}`}>
                  <RunName id={run.parent_run_id} />
                </Link>
              </Trans>
            </span>
          )}
          <Ago time={run.created_at} />
        </p>
        {run.notes && <p className={styles.notes}>{run.notes}</p>}
      </div>
      <RunActions run={run} behaviour={behaviour} />
      {describing && <DescribeRunDialog run={run} onClose={() => setDescribing(false)} />}
    </div>
  );
}
