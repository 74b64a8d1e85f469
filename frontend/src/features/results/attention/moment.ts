import type { RewardState } from "@/api/types";

/** Returns the address of a state in its recording, with the reward model of a run. */
export function momentPath(state: Omit<RewardState, "reward">, runId: string): string {
  const query = new URLSearchParams({ step: String(state.step), run: runId });
  return `/recordings/${state.recording_id}?${query.toString()}`;
}
