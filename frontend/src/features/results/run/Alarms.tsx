import { Trans } from "@lingui/react/macro";

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
            <a href="#curves">
              <Trans>See the curves</Trans>
            </a>
            {comparison.length > 0 && (
              <>
                {" "}
                <Trans>
                  or <a href="#games">watch the games</a>
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
            <a href="#check">
              <Trans>See which recordings</Trans>
            </a>
            .
          </p>
        </Notice>
      )}
    </>
  );
}
