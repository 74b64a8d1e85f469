import { queryOptions } from "@tanstack/react-query";

import { api, unwrap } from "./client";
import type { Recording } from "./types";

/** The recordings of other behaviours and of policies that a behaviour's ranking may hold. */
export function borrowedQuery(behaviourId: number) {
  return queryOptions({
    // Stale whenever the behaviour's own recordings are.
    queryKey: ["recordings", behaviourId, "borrowed"],
    queryFn: ({ signal }) =>
      unwrap(
        api.GET("/api/behaviours/{behaviour_id}/borrowed", {
          params: { path: { behaviour_id: behaviourId } },
          signal,
        }),
      ),
  });
}

/** Borrows games for a behaviour's ranking, unranked; all or none. */
export function addGames(behaviourId: number, ids: readonly number[]): Promise<Recording[]> {
  return unwrap(
    api.POST("/api/behaviours/{behaviour_id}/ranking/games", {
      params: { path: { behaviour_id: behaviourId } },
      body: { recording_ids: [...ids] },
    }),
  );
}

/** Gives a borrowed recording back, which is refused while it is ranked. */
export function giveBack(behaviourId: number, recordingId: number): Promise<unknown> {
  return unwrap(
    api.DELETE("/api/behaviours/{behaviour_id}/borrowed/{recording_id}", {
      params: { path: { behaviour_id: behaviourId, recording_id: recordingId } },
    }),
  );
}
