import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useMutation, useQueryClient } from "@tanstack/react-query";

import { messageOf } from "@/api/client";
import { cancelRun, resumeRun, runQuery } from "@/api/runs";
import type { Behaviour, Run } from "@/api/types";
import { Button, ButtonLink, IconButton } from "@/components/controls/Button";
import { useToast } from "@/components/feedback/Toasts";
import { useTakingAway } from "@/features/results/use-taking-away";
import { useMedia } from "@/lib/browser/use-media";
import { isActive } from "@/lib/runs";

import { againPath } from "./again";
import styles from "./RunActions.module.css";
import { useRunDeletion } from "./use-run-deletion";

/** Cancels an active run; shares, resumes or deletes any other; begins another one like it. */
export function RunActions({ run, behaviour }: { run: Run; behaviour: Behaviour }) {
  const client = useQueryClient();
  const toast = useToast();
  const remove = useRunDeletion(run);
  // On a phone they are one row.
  const narrow = useMedia("(max-width: 34rem)");
  const act = useMutation({
    mutationFn: (action: (runId: string) => Promise<Run>) => action(run.id),
    onSuccess: (changed) => {
      client.setQueryData(runQuery(run.id).queryKey, changed);
      void client.invalidateQueries({ queryKey: ["runs"] });
      void client.invalidateQueries({ queryKey: ["results", run.id] });
    },
    onError: (error) => toast(messageOf(error)),
  });
  const share = useTakingAway(run, behaviour, (error) => toast(messageOf(error)));
  const again = (
    <ButtonLink icon="redo" to={againPath(run)}>
      <Trans>Run again</Trans>
    </ButtonLink>
  );
  if (isActive(run)) {
    return (
      <div className={styles.actions}>
        <Button
          icon="close"
          disabled={act.isPending || run.status === "cancelling"}
          onClick={() => act.mutate(cancelRun)}
        >
          {run.status === "cancelling" ? t`Cancelling…` : t`Cancel run`}
        </Button>
        {again}
      </div>
    );
  }
  return (
    <div className={styles.actions}>
      {run.status !== "done" && (
        <Button
          // A stopped run's verdict leads to the ranking.
          kind={run.status === "stopped" ? "secondary" : "primary"}
          icon="play"
          disabled={act.isPending}
          onClick={() => act.mutate(resumeRun)}
        >
          {run.status === "stopped" ? t`Go on anyway` : t`Resume run`}
        </Button>
      )}
      {run.status === "done" && (
        <Button
          icon="upload"
          // Disabled, it would lose the focus.
          aria-disabled={share.isPending}
          onClick={() => {
            if (!share.isPending) share.mutate("page.html");
          }}
        >
          {share.isPending ? t`Making the page…` : t`Share`}
        </Button>
      )}
      {again}
      {narrow ? (
        <IconButton
          icon="trash"
          kind="secondary"
          label={t`Delete run`}
          disabled={remove.isPending}
          onClick={() => remove.mutate()}
        />
      ) : (
        <Button icon="trash" disabled={remove.isPending} onClick={() => remove.mutate()}>
          <Trans>Delete run</Trans>
        </Button>
      )}
    </div>
  );
}
