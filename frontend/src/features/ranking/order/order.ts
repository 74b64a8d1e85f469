/**
 * Pure functions that change an order. Tiers are listed best first; none is empty, and no recording
 * is in two of them. Recordings in no tier are unranked.
 */

export type Tiers = readonly (readonly number[])[];

/** Where to put a recording; indices refer to the tiers before the change. */
export type Place =
  /** Into a tier, tied with its recordings. */
  | { readonly kind: "tier"; readonly tier: number }
  /** Into a new tier before this index; the number of tiers means at the end. */
  | { readonly kind: "gap"; readonly before: number }
  | { readonly kind: "tray" };

/** Returns the index of a recording's tier; -1 if it is unranked. */
export function tierOf(tiers: Tiers, id: number): number {
  return tiers.findIndex((tier) => tier.includes(id));
}

/** Moves a recording to a place. */
export function place(tiers: Tiers, id: number, to: Place): Tiers {
  return placeAll(tiers, [id], to);
}

/** Moves recordings to a place, tied with each other; those in that tier already keep their place. */
export function placeAll(tiers: Tiers, ids: readonly number[], to: Place): Tiers {
  const without = tiers.map((tier) => tier.filter((id) => !ids.includes(id)));
  if (to.kind === "tier") {
    return withoutEmpty(
      tiers.map((tier, index) =>
        index === to.tier
          ? [...tier, ...ids.filter((id) => !tier.includes(id))]
          : (without[index] ?? []),
      ),
    );
  }
  if (to.kind === "gap") {
    return withoutEmpty([...without.slice(0, to.before), ids, ...without.slice(to.before)]);
  }
  return withoutEmpty(without);
}

function withoutEmpty(tiers: Tiers): Tiers {
  return tiers.filter((tier) => tier.length > 0);
}

/** Moves a recording up: out of a tie to just above it, or past the tier above. */
export function moveUp(tiers: Tiers, id: number): Tiers {
  const at = tierOf(tiers, id);
  if (at < 0) return tiers;
  if (isTied(tiers, id)) return place(tiers, id, { kind: "gap", before: at });
  return at === 0 ? tiers : place(tiers, id, { kind: "gap", before: at - 1 });
}

/** Moves a recording down: out of a tie to just below it, or past the tier below. */
export function moveDown(tiers: Tiers, id: number): Tiers {
  const at = tierOf(tiers, id);
  if (at < 0) return tiers;
  if (isTied(tiers, id)) return place(tiers, id, { kind: "gap", before: at + 1 });
  return at === tiers.length - 1 ? tiers : place(tiers, id, { kind: "gap", before: at + 2 });
}

/** Ties a recording with the tier above. */
export function joinAbove(tiers: Tiers, id: number): Tiers {
  const at = tierOf(tiers, id);
  return at <= 0 ? tiers : place(tiers, id, { kind: "tier", tier: at - 1 });
}

/** Gives a recording a tier of its own: below those it was tied with, or last if unranked. */
export function newTier(tiers: Tiers, id: number): Tiers {
  const at = tierOf(tiers, id);
  if (at < 0) return place(tiers, id, { kind: "gap", before: tiers.length });
  return isTied(tiers, id) ? place(tiers, id, { kind: "gap", before: at + 1 }) : tiers;
}

/** Makes the worst the best. */
export function turnRound(tiers: Tiers): Tiers {
  return tiers.toReversed();
}

/** Whether a recording shares its tier. */
export function isTied(tiers: Tiers, id: number): boolean {
  return (tiers[tierOf(tiers, id)]?.length ?? 0) > 1;
}

/** Counts the preference pairs that an order implies. */
export function pairCount(tiers: Tiers): number {
  let above = 0;
  let pairs = 0;
  for (const tier of tiers) {
    pairs += above * tier.length;
    above += tier.length;
  }
  return pairs;
}

/** Whether two orders have the same tiers. */
export function sameOrder(a: Tiers, b: Tiers): boolean {
  return (
    a.length === b.length &&
    a.every((tier, index) => {
      const other = b[index] ?? [];
      return tier.length === other.length && tier.every((id) => other.includes(id));
    })
  );
}

/**
 * Returns the recordings that moved between two orders: those that only one of them ranks, and,
 * greedily, the few without which the orders agree on all others.
 */
export function movedBetween(a: Tiers, b: Tiers): ReadonlySet<number> {
  const [inA, inB] = [tierNumbers(a), tierNumbers(b)];
  const all = new Set([...inA.keys(), ...inB.keys()]);
  const moved = new Set([...all].filter((id) => !inA.has(id) || !inB.has(id)));
  const rest = new Set([...all].filter((id) => !moved.has(id)));
  const isDisputed = (id: number, other: number) =>
    relation(inA, id, other) !== relation(inB, id, other);
  const disputes = new Map(
    [...rest].map((id) => [id, [...rest].filter((other) => isDisputed(id, other)).length]),
  );
  for (;;) {
    let [culprit, most] = [0, 0];
    for (const id of rest) {
      const n = disputes.get(id) ?? 0;
      if (n > most) [culprit, most] = [id, n];
    }
    if (most === 0) return moved;
    moved.add(culprit);
    rest.delete(culprit);
    for (const id of rest)
      if (isDisputed(id, culprit)) disputes.set(id, (disputes.get(id) ?? 0) - 1);
  }
}

function tierNumbers(tiers: Tiers): ReadonlyMap<number, number> {
  return new Map(tiers.flatMap((tier, index) => tier.map((id) => [id, index] as const)));
}

/** -1: above, 0: tied, 1: below. */
function relation(tierOf: ReadonlyMap<number, number>, id: number, other: number): number {
  return Math.sign((tierOf.get(id) ?? -1) - (tierOf.get(other) ?? -1));
}
