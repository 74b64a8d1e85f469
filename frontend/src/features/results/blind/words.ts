/** Words for the result of a blind comparison. */
import { t } from "@lingui/core/macro";

import type { BlindResult } from "@/api/types";
import { fixed, listed, percent, whole } from "@/lib/format";

/** Writes a number of wins, of which equal pairs count half: "7", "6.5". */
export function wins(n: number): string {
  return Number.isInteger(n) ? whole(n) : fixed(n, 1);
}

/** Writes a result: "The imitator won 7 of 10 (40% to 89%): 4 of 5 against the clone, …". */
export function describeBlind({ wins: won, share, against }: BlindResult): string {
  const parts = against.map(({ opponent, wins: part, n }) =>
    opponent === "clone"
      ? t`${wins(part)} of ${n} against the clone`
      : t`${wins(part)} of ${n} against demonstrations`,
  );
  const [low, high] = [percent(share.low, 0), percent(share.high, 0)];
  return t`The imitator won ${wins(won)} of ${share.n} (${low} to ${high}): ${listed(parts)}.`;
}
