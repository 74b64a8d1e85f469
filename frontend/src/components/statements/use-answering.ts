import { t } from "@lingui/core/macro";
import { queryOptions, useMutation, useQueryClient } from "@tanstack/react-query";
import { useState } from "react";

import { api, messageOf, unwrap } from "@/api/client";
import type { Understanding } from "@/api/types";
import { useToast } from "@/components/feedback/Toasts";

import type { Said } from "./statements";

/** What people said of the statements about a behaviour's ranking, the latest last. */
export function answersQuery(behaviourId: number) {
  return queryOptions({
    queryKey: ["ranking", behaviourId, "answers"],
    queryFn: ({ signal }) =>
      unwrap(
        api.GET("/api/behaviours/{behaviour_id}/ranking/answers", {
          params: { path: { behaviour_id: behaviourId } },
          signal,
        }),
      ),
  });
}

export interface Answering {
  /** Says whether a statement is meant; null takes back what was said of it. */
  readonly say: (statement: Said, meant: boolean | null) => void;
  /** Until then nothing else can be said. */
  readonly isAnswering: boolean;
  /** What was said last, for screen readers. */
  readonly spoken: string;
}

/** Answers statements about a behaviour's ranking. */
export function useAnswering(behaviourId: number): Answering {
  const client = useQueryClient();
  const toast = useToast();
  const [spoken, setSpoken] = useState("");
  const queryKey = ["understanding", behaviourId];
  const { mutate, isPending } = useMutation({
    mutationFn: ({ meant, subjects, sentence }: Said & { meant: boolean | null }) =>
      unwrap(
        api.PUT("/api/behaviours/{behaviour_id}/ranking/answers", {
          params: { path: { behaviour_id: behaviourId } },
          body: { subjects, sentence, meant },
        }),
      ),
    onSuccess: (answers) => {
      client.setQueryData(answersQuery(behaviourId).queryKey, answers);
      client.setQueriesData<Understanding>({ queryKey }, (old) => old && { ...old, answers });
    },
    onError: (problem: Error) => toast(messageOf(problem)),
    onSettled: () => client.invalidateQueries({ queryKey }),
  });

  function say({ subjects, sentence }: Said, meant: boolean | null) {
    if (isPending) return;
    mutate({ subjects, sentence, meant });
    if (meant === null) setSpoken(t`Taken back: ${sentence}.`);
    else if (meant) setSpoken(t`Noted as what you mean: ${sentence}.`);
    else setSpoken(t`Noted as not what you mean: ${sentence}.`);
  }

  return { say, isAnswering: isPending, spoken };
}
