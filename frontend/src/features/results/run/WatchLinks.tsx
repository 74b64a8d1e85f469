import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { RunResults } from "@/api/types";
import { ButtonLink } from "@/components/controls/Button";
import { inSentence } from "@/lib/format";
import { actorNames } from "@/lib/actors";

import styles from "./RunActions.module.css";

const POLICIES = ["imitator", "clone"] as const;

/** Leads to the pages on which a run's policies play live, as soon as they are trained. */
export function WatchLinks({ results: { run, artifacts } }: { results: RunResults }) {
  const trained = POLICIES.filter((policy) => artifacts.some(({ kind }) => kind === policy));
  if (trained.length === 0) return null;
  return (
    <div className={styles.actions} role="group" aria-label={t`Watch it play`}>
      {trained.map((policy) => (
        <ButtonLink key={policy} icon="play" to={watchPath(run.id, [policy])}>
          <Trans>Watch the {inSentence(actorNames()[policy])} play</Trans>
        </ButtonLink>
      ))}
      {trained.length > 1 && (
        <ButtonLink icon="compare" to={watchPath(run.id, trained)}>
          <Trans>Both side by side</Trans>
        </ButtonLink>
      )}
    </div>
  );
}

function watchPath(runId: string, policies: readonly string[]): string {
  const players = policies.map((policy) => ["player", `${policy}.greedy`]);
  return `/runs/${runId}/watch?${new URLSearchParams([...players, ["start", "0"]])}`;
}
