import { keepPreviousData, queryOptions, useQuery } from "@tanstack/react-query";
import { useMemo } from "react";

import { api, unwrap } from "@/api/client";
import type { GameOpinion, RankingOpinion } from "@/api/types";
import { sameOrder } from "@/features/ranking/order/order";
import type { SaverState } from "@/features/ranking/order/saver";

/** What it takes to have an opinion: see OpinionBar. */
const LEAST_TIERS = 2;
const LEAST_RANKED = 4;

function opinionQuery(behaviourId: number, revision: number) {
  return queryOptions({
    queryKey: ["opinion", behaviourId, revision],
    queryFn: ({ signal }) =>
      unwrap(
        api.GET("/api/behaviours/{behaviour_id}/ranking/opinion", {
          params: { path: { behaviour_id: behaviourId } },
          signal,
        }),
      ),
    // What was said of the order before stays until the new answer is there.
    placeholderData: keepPreviousData,
  });
}

export interface Opinions {
  readonly of: ReadonlyMap<number, GameOpinion>;
  /** Whether they are of the order shown, so that their tiers are those on the board. */
  readonly current: boolean;
  readonly answer: RankingOpinion | undefined;
  /** Whether they are being worked out for the first time, and there will be some. */
  readonly awaited: boolean;
  readonly error: unknown;
}

/** Returns what the ranking says of each game, asked anew after each saved change. */
export function useOpinions(
  behaviourId: number,
  { saved, tiers }: SaverState,
  enabled: boolean,
): Opinions {
  const { data, error } = useQuery({ ...opinionQuery(behaviourId, saved.revision), enabled });
  const isEnough = saved.tiers.length >= LEAST_TIERS && saved.tiers.flat().length >= LEAST_RANKED;
  const answer = enabled ? data : undefined;
  const of = useMemo(
    () => new Map(answer?.games.map((game) => [game.recording_id, game])),
    [answer],
  );
  const current = answer?.revision === saved.revision && sameOrder(saved.tiers, tiers);
  const awaited = enabled && isEnough && !data && error === null;
  return { of, current, answer, awaited, error };
}
