import { Trans } from "@lingui/react/macro";
import { Link } from "react-router";

import type { RunResults } from "@/api/types";
import { Notice } from "@/components/feedback/States";

/** Warnings about the learned reward, above all results. */
export function Alarms({ results }: { results: RunResults }) {
  const { alarm, check, comparison } = results;
  return (
    <>
      {alarm && (
        <Notice tone="bad" live>
          <p>
            <strong>
              <Trans>The reward may be hacked.</Trans>
            </strong>{" "}
            {alarm.message}{" "}
            <Link to="#curves">
              <Trans>See the curves</Trans>
            </Link>
            {comparison.length > 0 && (
              <>
                {" "}
                <Trans>
                  or <Link to="#games">watch the games</Link>
                </Trans>
              </>
            )}
            .
          </p>
        </Notice>
      )}
      {check?.warning && (
        <Notice live>
          <p>
            {check.warning}{" "}
            <Link to="#check">
              <Trans>See which recordings</Trans>
            </Link>
            .
          </p>
        </Notice>
      )}
    </>
  );
}
