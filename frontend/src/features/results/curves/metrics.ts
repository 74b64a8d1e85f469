import { queryOptions, useQueryClient } from "@tanstack/react-query";

import { api, unwrap } from "@/api/client";
import type { Metrics } from "@/api/types";

import { mergeSeries } from "./series";

/** The curves of a run; each fetch requests only the points since the last one. */
export function useMetricsQuery(runId: string) {
  const client = useQueryClient();
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
