import { queryOptions, useMutation, useQuery, useQueryClient } from "@tanstack/react-query";

import { api, unwrap } from "@/api/client";
import type { BlindAnswer, BlindComparison } from "@/api/types";
import type { Played } from "@/components/in-step/use-playback-in-step";

function at(runId: string) {
  return { params: { path: { run_id: runId } } };
}

function blindQuery(runId: string) {
  return queryOptions({
    queryKey: ["blind", runId],
    queryFn: ({ signal }) => unwrap(api.GET("/api/runs/{run_id}/blind", { ...at(runId), signal })),
  });
}

export interface Blind {
  /** Undefined until it is there. */
  readonly comparison: BlindComparison | undefined;
  /** Why the last answer was not kept. */
  readonly error: unknown;
  readonly busy: boolean;
  /** Judges the next pair, takes the last judgement back, or ends the round. */
  readonly answer: (answer: BlindAnswer) => void;
}

/** A person's blind comparison of a run's games, which the server keeps after each answer. */
export function useBlind(runId: string): Blind {
  const client = useQueryClient();
  const query = blindQuery(runId);
  const { data: comparison } = useQuery(query);
  const { mutate, isPending, error } = useMutation({
    mutationFn: (body: { round: number; pair: number; answer: BlindAnswer }) =>
      unwrap(api.POST("/api/runs/{run_id}/blind/answers", { ...at(runId), body })),
    onSuccess: (changed) => client.setQueryData(query.queryKey, changed),
    // It may have gone on in another tab.
    onError: () => void client.invalidateQueries(query),
  });
  return {
    comparison,
    error,
    busy: isPending,
    answer: (answer) => {
      if (isPending || !comparison) return;
      const { round, answers } = comparison;
      const judges = answer !== "taken back" && answer !== "ended";
      mutate({ round, pair: answers.length + (judges ? 1 : 0), answer });
    },
  };
}

/** Returns what plays a pair, left and right, by its number from 1. */
export function gamesOf({ frames_url: url }: BlindComparison, pair: number): [Played, Played] {
  const game = (side: string) => ({
    frames_url: url.replace("{pair}", String(pair)).replace("{side}", side),
  });
  return [game("left"), game("right")];
}
