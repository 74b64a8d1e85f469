/** The rows of the comparison between imitator and clone. */

import { t } from "@lingui/core/macro";

import type { Interval, PolicySummary } from "@/api/types";
import { fixed, measured, percent } from "@/lib/format";

interface SummaryRow {
  readonly key: keyof PolicySummary;
  readonly name: string;
  readonly imitator: Interval | null;
  readonly clone: Interval | null;
  readonly write: (value: number) => string;
  /** Bounds of the axis. */
  readonly low: number;
  readonly high: number;
}

const oneDigit = (value: number) => fixed(value, 1);
const wholePercent = (value: number) => percent(value, 0);

interface Plan {
  readonly key: keyof PolicySummary;
  readonly name: string;
  readonly write: (value: number) => string;
  readonly high?: number;
}

function plans(nTargets: number | null, ordered: boolean, maxSteps: number): readonly Plan[] {
  const target: Plan[] =
    nTargets === null
      ? []
      : [
          { key: "targets", name: t`Targets hit, of ${nTargets}`, write: oneDigit, high: nTargets },
          { key: "strays", name: t`Strays`, write: oneDigit },
          ...(ordered
            ? [{ key: "order_errors" as const, name: t`Hits out of order`, write: oneDigit }]
            : []),
          { key: "perfect", name: t`Perfect games`, write: wholePercent, high: 1 },
        ];
  return [
    ...target,
    { key: "steps", name: t`Game length, of ${maxSteps} steps`, write: oneDigit, high: maxSteps },
    { key: "death_rate", name: t`Death rate`, write: wholePercent, high: 1 },
    { key: "predicted_return", name: t`Predicted return`, write: measured },
  ];
}

/** Returns the rows for which at least one of the two has a value. */
export function summaryRows(
  imitator: PolicySummary | null,
  clone: PolicySummary | null,
  nTargets: number | null,
  ordered: boolean,
  maxSteps: number,
): readonly SummaryRow[] {
  return plans(nTargets, ordered, maxSteps)
    .map(({ key, name, write, high }) => {
      const both = { imitator: imitator?.[key] ?? null, clone: clone?.[key] ?? null };
      return { key, name, write, ...both, ...axisOf([both.imitator, both.clone], high) };
    })
    .filter((row) => row.imitator !== null || row.clone !== null);
}

function axisOf(
  intervals: readonly (Interval | null)[],
  high: number | undefined,
): { low: number; high: number } {
  if (high !== undefined) return { low: 0, high };
  const ends = intervals.flatMap((one) => (one ? [one.low, one.high] : []));
  return { low: Math.min(0, ...ends), high: Math.max(0, ...ends) };
}
