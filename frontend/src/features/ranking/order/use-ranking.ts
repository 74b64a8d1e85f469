import { useQueryClient } from "@tanstack/react-query";
import { useEffect, useState, useSyncExternalStore } from "react";

import { isPassing } from "@/api/client";
import type { Ranking } from "@/api/types";

import { RankingConflictError, rankingQuery, saveRanking, stepRanking } from "./rankings";
import { RankingSaver, type SaverState } from "./saver";

/** Returns the state of the ranking and its saver. */
export function useRankingSaver(ranking: Ranking): [SaverState, RankingSaver] {
  const client = useQueryClient();
  const behaviourId = ranking.behaviour_id;
  const [saver] = useState(() => {
    const { queryKey } = rankingQuery(behaviourId);
    const cached = async (answer: Promise<Ranking>): Promise<Ranking> => {
      // A response still in flight could be older than this one.
      await client.cancelQueries({ queryKey });
      const saved = await answer;
      client.setQueryData(queryKey, saved);
      void client.invalidateQueries({ queryKey: ["behaviours"] });
      return saved;
    };
    return new RankingSaver(ranking, {
      save: (base, tiers) => cached(saveRanking(behaviourId, base, tiers)),
      step: (base, step) => cached(stepRanking(behaviourId, base, step)),
      conflictOf: (error) => (error instanceof RankingConflictError ? error.current : null),
    });
  });
  useEffect(() => saver.receive(ranking), [saver, ranking]);
  const state = useSyncExternalStore(saver.subscribe, saver.snapshot);
  useRetry(saver, state.error);
  return [state, saver];
}

const RETRY_MS = 5000;

/** Saves again after a failure that may pass: regularly, and once the network is back. */
function useRetry(saver: RankingSaver, error: unknown): void {
  useEffect(() => {
    if (error === null || !isPassing(error)) return undefined;
    const retry = () => saver.retry();
    const timer = setTimeout(retry, RETRY_MS);
    window.addEventListener("online", retry);
    return () => {
      clearTimeout(timer);
      window.removeEventListener("online", retry);
    };
  }, [saver, error]);
}
