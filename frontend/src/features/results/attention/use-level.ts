import { useQuery } from "@tanstack/react-query";

import { rewardTraceQuery } from "@/api/runs";
import type { RunResults } from "@/api/types";
import { fixed, NONE } from "@/lib/format";

/** Returns how to write R on the page's scale, which any game's curve knows; "–" until it does. */
export function useLevel({ run, attention }: RunResults): (reward: number) => string {
  const recordingId = attention[0]?.recording_id;
  const { data } = useQuery({
    ...rewardTraceQuery(run.id, recordingId ?? 0),
    enabled: recordingId !== undefined,
  });
  if (!data) return () => NONE;
  const { zero_level_reward: zero, unit_level_reward: unit } = data;
  return (reward) => fixed((reward - zero) / (unit - zero), 2);
}
