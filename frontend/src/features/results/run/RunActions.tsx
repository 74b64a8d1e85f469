import { useMutation, useQueryClient } from "@tanstack/react-query";
import { useState } from "react";
import { useNavigate } from "react-router";

import { messageOf } from "@/api/client";
import { cancelRun, deleteRun, resumeRun, runQuery } from "@/api/runs";
import type { Run } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
import { useToast } from "@/components/feedback/Toasts";
import { isActive, runName } from "@/lib/runs";

import styles from "./RunActions.module.css";

/** Cancels an active run; resumes or deletes any other. */
export function RunActions({ run }: { run: Run }) {
  const client = useQueryClient();
  const toast = useToast();
  const navigate = useNavigate();
  const [deleting, setDeleting] = useState(false);

  const act = useMutation({
    mutationFn: (action: (runId: string) => Promise<Run>) => action(run.id),
    onSuccess: (changed) => {
      client.setQueryData(runQuery(run.id).queryKey, changed);
      void client.invalidateQueries({ queryKey: ["runs"] });
      void client.invalidateQueries({ queryKey: ["results", run.id] });
    },
    onError: (error) => toast(messageOf(error)),
  });
  const remove = useMutation({
    mutationFn: () => deleteRun(run.id),
    onSuccess: async () => {
      await navigate(`/behaviours/${run.behaviour_id}/runs`);
      void client.invalidateQueries({ queryKey: ["runs"] });
      void client.invalidateQueries({ queryKey: ["behaviours"] });
    },
    onError: (error) => {
      setDeleting(false);
      toast(messageOf(error));
    },
  });

  if (isActive(run)) {
    return (
      <div className={styles.actions}>
        <Button
          icon="close"
          disabled={act.isPending || run.status === "cancelling"}
          onClick={() => act.mutate(cancelRun)}
        >
          {run.status === "cancelling" ? "Cancelling…" : "Cancel run"}
        </Button>
      </div>
    );
  }
  return (
    <div className={styles.actions}>
      {run.status !== "done" && (
        <Button
          kind="primary"
          icon="play"
          disabled={act.isPending}
          onClick={() => act.mutate(resumeRun)}
        >
          {run.status === "stopped" ? "Go on anyway" : "Resume run"}
        </Button>
      )}
      <Button icon="trash" onClick={() => setDeleting(true)}>
        Delete run
      </Button>
      {deleting && (
        <Dialog
          title={`Delete ${runName(run).toLowerCase()}?`}
          onClose={() => setDeleting(false)}
          width="26rem"
        >
          <p>
            Its results are no longer shown. Recordings and the ranking stay as they are, its games
            in them, too.
          </p>
          <br />
          <div className={styles.actions}>
            <Button kind="danger" disabled={remove.isPending} onClick={() => remove.mutate()}>
              Delete
            </Button>
            <Button kind="quiet" onClick={() => setDeleting(false)}>
              Keep it
            </Button>
          </div>
        </Dialog>
      )}
    </div>
  );
}
