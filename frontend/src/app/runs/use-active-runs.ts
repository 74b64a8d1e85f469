import { t } from "@lingui/core/macro";
import { useQuery, useQueryClient } from "@tanstack/react-query";
import { useEffect, useRef } from "react";
import { useLocation, useNavigate } from "react-router";

import { activeRunsQuery, resultsQuery } from "@/api/runs";
import type { Run } from "@/api/types";
import { useToast } from "@/components/feedback/Toasts";
import { useOnlyPlays } from "@/components/people/use-only-plays";
import { notify } from "@/lib/browser/notifications";

/** Follows the runs that are not over: announces each that ends; returns the tab's title or null. */
export function useActiveRuns(): string | null {
  const { data: runs } = useQuery({ ...activeRunsQuery, enabled: useOnlyPlays() === false });
  useEndings(runs);
  const training = runs?.find(({ status }) => status === "running");
  return training ? titleOf(training) : null;
}

function titleOf({ progress, behaviour_name: name }: Run): string {
  return t`${Math.floor(progress * 100)}% · ${name} – Tril`;
}

/** Shows the verdict of each run that was active and is no more, wherever the person is. */
function useEndings(runs: readonly Run[] | undefined): void {
  const client = useQueryClient();
  const navigate = useNavigate();
  const toast = useToast();
  const before = useRef<readonly Run[]>([]);
  const { pathname } = useLocation();
  const shown = useRef(pathname);
  useEffect(() => {
    shown.current = pathname;
  }, [pathname]);
  useEffect(() => {
    if (!runs) return;
    const ended = before.current.filter(({ id }) => !runs.some((run) => run.id === id));
    before.current = runs;
    for (const { id } of ended) {
      // Deleted runs have no results; of what a person cancelled, nothing needs to be said.
      client
        .query({ ...resultsQuery(id), staleTime: 0, retry: false })
        .then(({ run, verdict }) => {
          if (!verdict || run.status === "cancelled") return;
          const path = `/runs/${id}`;
          const look = () => void navigate(path);
          // The page of the run says it itself.
          if (shown.current !== path)
            toast(`${run.behaviour_name}: ${verdict.sentence}`, { label: t`Look`, run: look });
          notify(t`Run of ${run.behaviour_name} ended`, verdict.sentence, id, look);
        })
        .catch(() => undefined);
    }
  }, [client, navigate, runs, toast]);
}
