import { queryOptions } from "@tanstack/react-query";

import { api, unwrap } from "./client";
import type { Behaviour, BehaviourNew } from "./types";

export const behavioursQuery = queryOptions({
  queryKey: ["behaviours"],
  queryFn: ({ signal }) => unwrap(api.GET("/api/behaviours", { signal })),
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

/** The demonstrations that exemplify a behaviour, and which of them were played. */
export function checklistQuery(behaviourId: number) {
  return queryOptions({
    // What makes the numbers of recordings stale makes this stale, too.
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

/** Where the cannon of the best demonstration stood in every frame; null without one. */
export function ghostQuery(behaviourId: number) {
  return queryOptions({
    // What is ranked or marked anew may be another one; otherwise it stays.
    queryKey: ["behaviours", behaviourId, "ghost"],
    staleTime: Infinity,
    queryFn: ({ signal }) =>
      unwrap(
        api.GET("/api/behaviours/{behaviour_id}/ghost", {
          params: { path: { behaviour_id: behaviourId } },
          signal,
        }),
      ),
  });
}

export function createBehaviour(body: BehaviourNew): Promise<Behaviour> {
  return unwrap(api.POST("/api/behaviours", { body }));
}

export function deleteBehaviour(behaviourId: number): Promise<unknown> {
  return unwrap(
    api.DELETE("/api/behaviours/{behaviour_id}", {
      params: { path: { behaviour_id: behaviourId } },
    }),
  );
}
