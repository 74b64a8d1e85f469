import type { Run } from "@/api/types";

/** The address of the training form with a run's recipe and settings filled in. */
export function againPath(run: Run): string {
  const search = new URLSearchParams({
    recipe: run.recipe,
    steps: String(run.steps),
    seed: String(run.training_seed),
    rate: String(run.learning_rate),
  });
  if (run.go_on_anyway) search.set("anyway", "1");
  if (run.device === "gpu") search.set("gpu", "1");
  if (run.parent_run_id !== null) search.set("continue", run.parent_run_id);
  return `/behaviours/${run.behaviour_id}/train?${search.toString()}`;
}
