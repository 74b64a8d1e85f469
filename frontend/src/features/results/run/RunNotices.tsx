import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { Link } from "react-router";

import { hasGpu, isAlive, systemQuery } from "@/api/system";
import type { Run } from "@/api/types";
import { Notice } from "@/components/feedback/States";
import { isActive } from "@/lib/runs";

/** Notices about a run: an example, a missing worker, a message. */
export function RunNotices({ run }: { run: Run }) {
  const { data: system } = useQuery(systemQuery);
  const waitsForGpu = run.status === "queued" && run.device === "gpu" && hasGpu(system) === false;
  const waiting =
    !waitsForGpu && isActive(run) && !run.worker_alive && isAlive(system, "worker") === false;
  return (
    <>
      {run.example && (
        <Notice tone="calm" icon="eye">
          <p>
            <Trans>
              This is an example: its demonstrations were made by a scripted player, not by a
              person.
            </Trans>
            {run.imported && (
              <>
                {" "}
                <Trans>It was trained elsewhere; delete it when you like.</Trans>
              </>
            )}
          </p>
          <Link to="/">
            <Trans>Teach a behaviour yourself</Trans>
          </Link>
        </Notice>
      )}
      {run.imported && !run.example && (
        <Notice tone="calm" icon="eye">
          <p>
            <Trans>This run was imported: it was trained elsewhere.</Trans>
          </p>
        </Notice>
      )}
      {waitsForGpu && (
        <Notice live>
          <p>
            <Trans>This run waits for a worker with a GPU; none is running.</Trans>
          </p>
        </Notice>
      )}
      {waiting && (
        <Notice live>
          <p>
            <Trans>
              The worker isn&rsquo;t running, so this run makes no progress. Start it with{" "}
              <code>tril up</code>; the run then continues where it stopped.
            </Trans>
          </p>
        </Notice>
      )}
      {run.message && !isSaidByVerdict(run) && (
        <Notice tone={run.status === "failed" ? "bad" : "warn"} live>
          <p>{run.message}</p>
        </Notice>
      )}
    </>
  );
}

/** Whether a run was cancelled before its imitator had played: the verdict says all there is to say. */
function isSaidByVerdict({ status, headline }: Run): boolean {
  return status === "cancelled" && !headline?.imitator;
}
