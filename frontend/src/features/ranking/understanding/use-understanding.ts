import { keepPreviousData, queryOptions, useQuery } from "@tanstack/react-query";

import { api, unwrap } from "@/api/client";
import type { Behaviour, Understanding } from "@/api/types";
import type { Tiers } from "@/features/ranking/order/order";
import { viewOf } from "@/games/views";

/** How often the server is asked again while it learns to see the game or watches games. */
const AGAIN_MS = 1000;

/**
 * Whether Tril says in statements what an order is about. Where the items that a game takes describe
 * the behaviour, and the page can draw them, it shows which of them are wanted instead.
 */
export function isReadByStatements({ game, target }: Behaviour): boolean {
  return target === null || !viewOf(game)?.Wanted;
}

function understandingQuery(behaviourId: number, tiers: Tiers, kind: "next" | readonly number[]) {
  return queryOptions({
    queryKey: ["understanding", behaviourId, tiers, kind],
    queryFn: ({ signal }) =>
      unwrap(
        api.POST("/api/behaviours/{behaviour_id}/ranking/understanding", {
          params: { path: { behaviour_id: behaviourId } },
          body: { tiers: tiers.map((tier) => [...tier]), with_next: kind === "next" },
          signal,
        }),
      ),
    // What was said of the order before stays until the new answer is there.
    placeholderData: keepPreviousData,
    refetchInterval: ({ state }) =>
      state.data?.state === "learning" || state.data?.state === "watching" ? AGAIN_MS : false,
  });
}

/** What Tril understands of the order shown, once it has watched the unranked games, too. */
export function nextGameQuery(behaviourId: number, tiers: Tiers) {
  return understandingQuery(behaviourId, tiers, "next");
}

/**
 * Returns what Tril understands of the order shown, asked anew after each change.
 *
 * @param perfect The best efforts, which it is inferred from, too; null while they are not known.
 */
export function useUnderstanding(
  behaviourId: number,
  tiers: Tiers,
  perfect: readonly number[] | null,
): { told: Understanding | undefined; error: unknown } {
  const { data, error } = useQuery({
    ...understandingQuery(behaviourId, tiers, perfect ?? []),
    enabled: perfect !== null,
  });
  return { told: data, error };
}
