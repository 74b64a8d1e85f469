/**
 * Names of the board's drop places. They name recordings, so that a place is still the same one
 * when the order has changed.
 */

import { plural, t } from "@lingui/core/macro";

import {
  movedBetween,
  type Place,
  sameOrder,
  tierOf,
  type Tiers,
  turnRound,
} from "@/features/ranking/order/order";
import type { Stepped } from "@/features/ranking/order/saver";

export const TRAY = "tray";

const LAST_GAP = "gap-last";

/** The name of a tier, for putting something into it. */
export function tierPlace(tier: readonly number[]): string {
  return `tier-${tier[0] ?? ""}`;
}

/** The name of the gap above a tier; without one, of the gap below all. */
export function gapPlace(below?: readonly number[]): string {
  return below ? `gap-${below[0] ?? ""}` : LAST_GAP;
}

/** Returns all places from best to worst, then the tray: the order of the arrow keys. */
export function allPlaces(tiers: Tiers): readonly string[] {
  const places = tiers.flatMap((tier) => [gapPlace(tier), tierPlace(tier)]);
  return [...places, gapPlace(), TRAY];
}

export function isGap(place: string): boolean {
  return place.startsWith("gap-");
}

/** Returns where a place is in an order; null if its recording is no longer ranked. */
export function findPlace(place: string, tiers: Tiers): Place | null {
  if (place === TRAY) return { kind: "tray" };
  if (place === LAST_GAP) return { kind: "gap", before: tiers.length };
  const at = tierOf(tiers, Number(place.slice(place.indexOf("-") + 1)));
  if (at < 0) return null;
  return isGap(place) ? { kind: "gap", before: at } : { kind: "tier", tier: at };
}

/** Describes a place, for announcements. */
export function describePlace(place: string, tiers: Tiers): string {
  const to = findPlace(place, tiers);
  if (!to) return t`a place that is gone`;
  if (to.kind === "tray") return t`unranked`;
  if (to.kind === "tier") {
    const n = tiers[to.tier]?.length ?? 0;
    const [tier, of] = [to.tier + 1, tiers.length];
    return t`tier ${tier} of ${of}, with ${plural(n, { one: "1 recording", other: "# recordings" })}`;
  }
  if (tiers.length === 0) return t`the first tier`;
  if (to.before === 0) return t`new tier, best of all`;
  if (to.before === tiers.length) return t`new tier, worst of all`;
  return t`new tier between tiers ${to.before} and ${to.before + 1}`;
}

/** Describes where a recording is, for announcements. */
export function describePosition(tiers: Tiers, id: number): string {
  const at = tierOf(tiers, id);
  if (at < 0) return t`unranked`;
  const others = (tiers[at]?.length ?? 1) - 1;
  const [tier, of] = [at + 1, tiers.length];
  return others === 0
    ? t`tier ${tier} of ${of}, alone`
    : t`tier ${tier} of ${of}, tied with ${others}`;
}

/** The most recordings that an announcement names. */
const MOST_NAMED = 3;

/** Describes what an undo or redo changed, for announcements. */
export function describeStep(
  step: "undo" | "redo",
  { from, to }: Stepped,
  nameOf: (id: number) => string,
): string {
  const done = step === "undo" ? t`Undone.` : t`Redone.`;
  return `${done} ${describeChange(from, to, nameOf)}`.trim();
}

function describeChange(from: Tiers, to: Tiers, nameOf: (id: number) => string): string {
  // The reverse of two tiers is also one recording that moved.
  if (from.length > 2 && sameOrder(turnRound(from), to)) return t`The order is reversed.`;
  const moved = [...movedBetween(from, to)];
  if (moved.length > MOST_NAMED) {
    return plural(moved.length, {
      one: "# recording has another place.",
      other: "# recordings have other places.",
    });
  }
  return moved.map((id) => `${nameOf(id)}: ${describePosition(to, id)}.`).join(" ");
}
