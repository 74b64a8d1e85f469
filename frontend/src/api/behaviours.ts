import { queryOptions } from "@tanstack/react-query";

import { api, patientFetch, unwrap } from "./client";
import { after, everyPage } from "./batches";
import type { Behaviour, BehaviourNew, BehaviourUpdate } from "./types";

export const behavioursQuery = queryOptions({
  queryKey: ["behaviours"],
  queryFn: ({ signal }) =>
    everyPage<Behaviour>((last, limit) =>
      unwrap(api.GET("/api/behaviours", { params: { query: { limit, ...after(last) } }, signal })),
    ),
});

export function behaviourQuery(behaviourId: number) {
  return queryOptions({
    queryKey: ["behaviours", behaviourId],
    queryFn: ({ signal }) =>
      unwrap(
        api.GET("/api/behaviours/{behaviour_id}", {
          params: { path: { behaviour_id: behaviourId } },
          signal,
        }),
      ),
  });
}

/** The demonstrations to play for a behaviour, each with the recording that shows it, if any. */
export function checklistQuery(behaviourId: number) {
  return queryOptions({
    // Below the behaviour's key, so that it goes stale with the counts of recordings.
    queryKey: ["behaviours", behaviourId, "checklist"],
    queryFn: ({ signal }) =>
      unwrap(
        api.GET("/api/behaviours/{behaviour_id}/checklist", {
          params: { path: { behaviour_id: behaviourId } },
          signal,
        }),
      ),
  });
}

/** The player's position in every frame of the best demonstration; null if there is none. */
export function ghostQuery(behaviourId: number) {
  return queryOptions({
    // Changes only with the ranking and the perfect marks, which invalidate the behaviour's key.
    queryKey: ["behaviours", behaviourId, "ghost"],
    staleTime: Infinity,
    queryFn: ({ signal }) =>
      unwrap(
        api.GET("/api/behaviours/{behaviour_id}/ghost", {
          params: { path: { behaviour_id: behaviourId } },
          signal,
          fetch: patientFetch,
        }),
      ),
  });
}

export function createBehaviour(body: BehaviourNew): Promise<Behaviour> {
  return unwrap(api.POST("/api/behaviours", { body }));
}

export function updateBehaviour(behaviourId: number, body: BehaviourUpdate): Promise<Behaviour> {
  return unwrap(api.PATCH("/api/behaviours/{behaviour_id}", { ...at(behaviourId), body }));
}

export function deleteBehaviour(behaviourId: number): Promise<unknown> {
  return unwrap(api.DELETE("/api/behaviours/{behaviour_id}", at(behaviourId)));
}

export function restoreBehaviour(behaviourId: number): Promise<Behaviour> {
  return unwrap(api.POST("/api/behaviours/{behaviour_id}/restore", at(behaviourId)));
}

function at(behaviourId: number) {
  return { params: { path: { behaviour_id: behaviourId } } };
}
