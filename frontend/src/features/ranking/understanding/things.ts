import { queryOptions } from "@tanstack/react-query";

import { api, unwrap } from "@/api/client";

/** What may be meant: of each kind of things that Tril sees in the game, and of what is no thing. */
export function thingsQuery(behaviourId: number) {
  return queryOptions({
    queryKey: ["things", behaviourId],
    queryFn: ({ signal }) =>
      unwrap(
        api.GET("/api/behaviours/{behaviour_id}/ranking/things", {
          params: { path: { behaviour_id: behaviourId } },
          signal,
        }),
      ),
    staleTime: Infinity,
  });
}

/** The things on the screen after a step of a recording, the largest first. */
export function inSightQuery(behaviourId: number, recordingId: number, step: number) {
  return queryOptions({
    queryKey: ["in sight", behaviourId, recordingId, step],
    queryFn: ({ signal }) =>
      unwrap(
        api.GET("/api/behaviours/{behaviour_id}/ranking/things/in-sight", {
          params: {
            path: { behaviour_id: behaviourId },
            query: { recording_id: recordingId, step },
          },
          signal,
        }),
      ),
    staleTime: Infinity,
    gcTime: 60_000,
  });
}
