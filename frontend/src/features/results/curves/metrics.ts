import { type QueryClient, queryOptions, useQueryClient } from "@tanstack/react-query";

import { api, unwrap } from "@/api/client";
import type { Metrics } from "@/api/types";

import { mergeSeries } from "./series";

/** The curves of a run; each fetch requests only the points since the last one. */
export function useMetricsQuery(runId: string) {
  return metricsQuery(useQueryClient(), runId);
}

/** The same of several runs. */
export function useMetricsQueries(runIds: readonly string[]) {
  const client = useQueryClient();
  return runIds.map((runId) => metricsQuery(client, runId));
}

/** The same for those who have the client. */
export function metricsQuery(client: QueryClient, runId: string) {
  const queryKey = ["metrics", runId];
  return queryOptions({
    queryKey,
    queryFn: async ({ signal }): Promise<Metrics> => {
      const have = client.getQueryData<Metrics>(queryKey);
      const more = await unwrap(
        api.GET("/api/runs/{run_id}/metrics", {
          params: { path: { run_id: runId }, query: { after: have?.last ?? 0 } },
          signal,
        }),
      );
      return have ? { last: more.last, series: mergeSeries(have.series, more.series) } : more;
    },
    structuralSharing: false,
  });
}
