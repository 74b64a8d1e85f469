import { queryOptions } from "@tanstack/react-query";

import { api, unwrap } from "@/api/client";

/** The games that can be taught, those played last first. */
export const catalogueQuery = queryOptions({
  queryKey: ["catalogue"],
  queryFn: ({ signal }) => unwrap(api.GET("/api/catalogue", { signal })),
});

/** A game: its screen, time, buttons and ends. It stays the same while the server runs. */
export function gameQuery(name: string) {
  return queryOptions({
    queryKey: ["game", name],
    queryFn: ({ signal }) =>
      unwrap(api.GET("/api/catalogue/games/{name}", { params: { path: { name } }, signal })),
    staleTime: Infinity,
    gcTime: Infinity,
  });
}
