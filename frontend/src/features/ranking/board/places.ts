/** Names of the board's drop places. */

import { plural, t } from "@lingui/core/macro";

import { type Place, tierOf, type Tiers } from "@/features/ranking/order/order";

export const TRAY = "tray";

export function tierPlace(tier: number): string {
  return `tier-${tier}`;
}

export function gapPlace(before: number): string {
  return `gap-${before}`;
}

/** Returns all places from best to worst, then the tray: the order of the arrow keys. */
export function allPlaces(tiers: Tiers): readonly string[] {
  const places = tiers.flatMap((_, tier) => [gapPlace(tier), tierPlace(tier)]);
  return [...places, gapPlace(tiers.length), TRAY];
}

export function isGap(place: string): boolean {
  return place.startsWith("gap-");
}

/** Parses the name of a place. */
export function readPlace(place: string): Place {
  if (place === TRAY) return { kind: "tray" };
  const number = Number(place.slice(place.indexOf("-") + 1));
  return isGap(place) ? { kind: "gap", before: number } : { kind: "tier", tier: number };
}

/** Describes a place, for announcements. */
export function describePlace(place: string, tiers: Tiers): string {
  const to = readPlace(place);
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
