import { useQuery } from "@tanstack/react-query";

import { runQuery } from "@/api/runs";
import { runName } from "@/lib/runs";

/** The name of a run of which only the id is known; that of a deleted run is its short id. */
export function RunName({ id }: { id: string }) {
  const { data: run } = useQuery(runQuery(id));
  return <>{runName(run ?? { id })}</>;
}
