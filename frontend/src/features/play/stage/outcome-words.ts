/** Sentences about how a game came out. */
import type { Behaviour } from "@/api/types";
import type { Ended } from "@/features/play/stream/text-messages";
import { count, FRAME_RATE_HZ, seconds } from "@/lib/format";

type Outcome = Pick<Ended, "targets" | "strays" | "hits" | "order_errors">;

/** Says how a game ended, and when. */
export function endSentence({ reason, frame }: Pick<Ended, "reason" | "frame">): string {
  const after = `after ${seconds(frame / FRAME_RATE_HZ)}`;
  switch (reason) {
    case "hit":
    case "lives":
      return `Hit by a bomb ${after}`;
    case "steps":
      return "Survived all 300 steps";
    case "cleared":
      return `All aliens gone ${after}`;
    case "landed":
      return `The aliens landed ${after}`;
    default:
      return `Stopped ${after}`;
  }
}

/** Says what a game hit. */
export function scoreSentence(ended: Outcome, { target }: Behaviour): string {
  const { targets, strays, hits, order_errors: errors } = ended;
  if (targets === null || strays === null) return `${count(hits.length, "alien")} hit`;
  const parts = [
    target ? `${targets} of ${target.length} targets` : `${targets} targets`,
    strays === 0 ? "no strays" : count(strays, "stray"),
  ];
  if (errors) parts.push(`${count(errors, "hit")} out of order`);
  return parts.join(", ");
}
