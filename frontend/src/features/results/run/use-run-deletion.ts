import { t } from "@lingui/core/macro";
import { useMutation, useQueryClient } from "@tanstack/react-query";
import { useNavigate } from "react-router";

import { messageOf } from "@/api/client";
import { deleteRun, restoreRun, runQuery } from "@/api/runs";
import type { Run } from "@/api/types";
import { useToast } from "@/components/feedback/Toasts";
import { runName } from "@/lib/runs";

/** Deletes a run and goes to the list of runs; its toast restores it. */
export function useRunDeletion(run: Run) {
  const client = useQueryClient();
  const navigate = useNavigate();
  const toast = useToast();
  const settle = () => {
    void client.invalidateQueries({ queryKey: ["runs"] });
    void client.invalidateQueries({ queryKey: ["behaviours"] });
  };
  const restore = useMutation({
    mutationFn: () => restoreRun(run.id),
    onSuccess: (restored) => client.setQueryData(runQuery(run.id).queryKey, restored),
    onError: (error) => toast(messageOf(error)),
    onSettled: settle,
  });
  return useMutation({
    mutationFn: () => deleteRun(run.id),
    onSuccess: async () => {
      await navigate(`/behaviours/${run.behaviour_id}/runs`);
      client.removeQueries({ queryKey: runQuery(run.id).queryKey });
      settle();
      toast(t`${runName(run)} deleted. Its recordings and the ranking stay as they are.`, {
        label: t`Undo`,
        run: () => restore.mutate(),
      });
    },
    onError: (error) => toast(messageOf(error)),
  });
}
