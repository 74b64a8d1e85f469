/** Pairs of recordings of which one branches off the other. */
import type { LibraryEntry } from "@/api/types";

import { place, tierOf, type Tiers } from "./order";

/** Two continuations of a game from the same frame. */
export interface BranchPair {
  readonly before: LibraryEntry;
  readonly after: LibraryEntry;
  /** The frame up to which they are identical. */
  readonly frame: number;
}

export type Verdict = "after" | "before" | "equal";

/** Returns the rankable pairs with at least one unranked recording, newest first. */
export function openPairs(
  tiers: Tiers,
  unranked: readonly number[],
  recordings: ReadonlyMap<number, LibraryEntry>,
): readonly BranchPair[] {
  const pairs: BranchPair[] = [];
  const isUnranked = new Set(unranked);
  const rankable = (id: number) => tierOf(tiers, id) >= 0 || isUnranked.has(id);
  for (const after of recordings.values()) {
    const before = after.parent && recordings.get(after.parent.recording_id);
    if (!before || !after.parent || !rankable(before.id) || !rankable(after.id)) continue;
    if (tierOf(tiers, before.id) >= 0 && tierOf(tiers, after.id) >= 0) continue;
    pairs.push({ before, after, frame: after.parent.frame });
  }
  return pairs.sort((a, b) => b.after.id - a.after.id);
}

/**
 * Ranks a pair. A recording that is ranked already stays where it is and the other goes next to
 * it; if neither is, both go to the end.
 */
export function judge(tiers: Tiers, { before, after }: BranchPair, verdict: Verdict): Tiers {
  const [better, worse] = verdict === "before" ? [before.id, after.id] : [after.id, before.id];
  const withOne =
    tierOf(tiers, better) < 0 && tierOf(tiers, worse) < 0
      ? place(tiers, better, { kind: "gap", before: tiers.length })
      : tiers;
  const at = Math.max(tierOf(withOne, better), tierOf(withOne, worse));
  const missing = tierOf(withOne, better) < 0 ? better : worse;
  if (verdict === "equal") return place(withOne, missing, { kind: "tier", tier: at });
  return place(withOne, missing, { kind: "gap", before: missing === better ? at : at + 1 });
}
