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
            <strong>The reward may be hacked.</strong> {alarm.message}{" "}
            <a href="#curves">See the curves</a>
            {comparison.length > 0 && (
              <>
                {" "}
                or <a href="#games">watch the games</a>
              </>
            )}
            .
          </p>
        </Notice>
      )}
      {check?.warning && (
        <Notice live>
          <p>
            {check.warning} <a href="#check">See which recordings</a>.
          </p>
        </Notice>
      )}
    </>
  );
}
