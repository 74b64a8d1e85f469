import { QueryClient } from "@tanstack/react-query";

import { ProblemError } from "@/api/client";

const RETRIES = 2;

/** A client whose data stays fresh until the event stream says otherwise. */
export function createQueryClient(): QueryClient {
  return new QueryClient({
    defaultOptions: {
      queries: {
        staleTime: 30_000,
        // A refusal stays a refusal; only silence and failures are worth another try.
        retry: (failures, error) =>
          failures < RETRIES && !(error instanceof ProblemError && error.status < 500),
      },
    },
  });
}
