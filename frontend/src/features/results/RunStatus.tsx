import type { Run } from "@/api/types";
import { Badge } from "@/components/feedback/Badge";
import { isActive, statusNames } from "@/lib/runs";

/** The state of a run. */
export function RunStatus({ run }: { run: Pick<Run, "status"> }) {
  const tone = isActive(run)
    ? "accent"
    : run.status === "done"
      ? "good"
      : run.status === "failed"
        ? "bad"
        : "warn";
  return (
    <Badge chip tone={tone}>
      {statusNames()[run.status]}
    </Badge>
  );
}
