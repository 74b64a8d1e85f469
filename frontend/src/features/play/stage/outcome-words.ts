/** Sentences about how a game came out. */

import { plural, t } from "@lingui/core/macro";

import type { Behaviour } from "@/api/types";
import type { Ended } from "@/features/play/stream/text-messages";
import { FRAME_RATE_HZ, seconds } from "@/lib/format";

type Outcome = Pick<Ended, "targets" | "strays" | "hits" | "order_errors">;

/** Says how a game ended, and when. */
export function endSentence({ reason, frame }: Pick<Ended, "reason" | "frame">): string {
  const time = seconds(frame / FRAME_RATE_HZ);
  switch (reason) {
    case "hit":
    case "lives":
      return t`Hit by a bomb after ${time}`;
    case "steps":
      return t`Survived all 300 steps`;
    case "cleared":
      return t`All aliens gone after ${time}`;
    case "landed":
      return t`The aliens landed after ${time}`;
    default:
      return t`Stopped after ${time}`;
  }
}

/** Says what a game hit. */
export function scoreSentence(ended: Outcome, { target }: Behaviour): string {
  const { targets, strays, hits, order_errors: errors } = ended;
  if (targets === null || strays === null)
    return plural(hits.length, { one: "# alien hit", other: "# aliens hit" });
  const parts = [
    target ? t`${targets} of ${target.length} targets` : t`${targets} targets`,
    strays === 0 ? t`no strays` : plural(strays, { one: "# stray", other: "# strays" }),
  ];
  if (errors)
    parts.push(plural(errors, { one: "# hit out of order", other: "# hits out of order" }));
  return parts.join(", ");
}
