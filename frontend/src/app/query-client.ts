import { QueryClient } from "@tanstack/react-query";

import { ProblemError } from "@/api/client";
import { setUnsaved } from "@/lib/browser/drafts";

const RETRIES = 2;

/**
 * Creates a query client; the change stream invalidates its data. Requests are made also where the
 * browser says that it is offline: Tril may run on this machine, or the browser be wrong.
 */
export function createQueryClient(): QueryClient {
  const client = new QueryClient({
    defaultOptions: {
      queries: {
        staleTime: 30_000,
        networkMode: "always",
        refetchOnReconnect: true,
        // A client error stays one; only network and server errors are worth a retry.
        retry: (failures, error) =>
          failures < RETRIES && !(error instanceof ProblemError && error.status < 500),
      },
      mutations: { networkMode: "always" },
    },
  });
  client
    .getMutationCache()
    .subscribe(() => setUnsaved("what is being sent", client.isMutating() > 0));
  return client;
}
