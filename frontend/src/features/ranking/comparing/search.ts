/**
 * Finds the place of an unranked recording by comparing it with ranked ones: bisection over the
 * tiers. Pure functions. Answers name recordings instead of tiers, so that they stay true when the
 * order changes.
 */
import type { GameOpinion } from "@/api/types";
import { type Place, tierOf, type Tiers } from "@/features/ranking/order/order";

/** How the recording that is to be placed compares with another. */
export type Verdict = "better" | "equal" | "worse";

export interface Answer {
  /** The ranked recording that it was compared with. */
  readonly opponent: number;
  readonly verdict: Verdict;
}

/** Some tiers, from `start` to before `end`; none is left where the two meet. */
interface Span {
  readonly start: number;
  readonly end: number;
}

export interface Expectation {
  /** The tier where the search begins. */
  readonly tier: number;
  /** The tiers to which it keeps until an answer contradicts. */
  readonly likely: Span;
}

/**
 * Returns the tiers of an order where an opinion expects a recording. It reads the opinion's places,
 * which hold for the next order, too; its tiers are numbered as in the order that was asked about.
 */
export function expectationOf(tiers: Tiers, opinion: GameOpinion): Expectation {
  const [tier, best, worst] = [opinion.place, opinion.best_place, opinion.worst_place].map(
    (share) => tierAt(tiers, share),
  ) as [number, number, number];
  return { tier, likely: { start: best, end: worst + 1 } };
}

/** Returns the tier that holds the game below a share of the ranked ones, as the server does. */
function tierAt(tiers: Tiers, share: number): number {
  const nRanked = tiers.flat().length;
  let above = 0;
  const at = tiers.findIndex((tier) => (above += tier.length) / nRanked >= share);
  return at < 0 ? Math.max(tiers.length - 1, 0) : at;
}

/** Returns the tiers that no answer excludes; if answers contradict each other, newer ones count. */
function open(tiers: Tiers, answers: readonly Answer[]): Span {
  let span: Span = { start: 0, end: tiers.length };
  for (const { opponent, verdict } of [...answers].reverse()) {
    const tier = tierOf(tiers, opponent);
    if (tier < 0 || verdict === "equal") continue;
    const next =
      verdict === "better"
        ? { start: span.start, end: Math.min(span.end, tier) }
        : { start: Math.max(span.start, tier + 1), end: span.end };
    if (next.start <= next.end) span = next;
  }
  return span;
}

/** Returns the place that answers have led to; null if more are needed. */
export function placeAfter(tiers: Tiers, answers: readonly Answer[]): Place | null {
  const last = answers.at(-1);
  if (!last) return null;
  const tier = tierOf(tiers, last.opponent);
  if (last.verdict === "equal" && tier >= 0) return { kind: "tier", tier };
  const { start, end } = open(tiers, answers);
  return start === end ? { kind: "gap", before: start } : null;
}

/**
 * Returns the tier to compare with next; null if none is left.
 *
 * Without an expectation it is the middle one, so that n tiers take at most ceil(log2(n + 1))
 * comparisons. With one it is the expected tier, then the middle of the likely ones; once all of
 * those are excluded, the steps away from them double (exponential search, Bentley and Yao 1976).
 */
export function nextTier(
  tiers: Tiers,
  answers: readonly Answer[],
  expected: Expectation | null,
): number | null {
  const span = open(tiers, answers);
  if (span.start === span.end) return null;
  if (!expected) return middle(span);
  if (isWithin(span, expected.tier)) return expected.tier;
  const { likely } = expected;
  const left = overlap(span, likely);
  if (left.start < left.end) return middle(left);
  if (span.end <= likely.start && span.start === 0)
    return Math.max(0, span.end - 1 - (likely.start - span.end));
  if (span.start >= likely.end && span.end === tiers.length)
    return Math.min(tiers.length - 1, span.start + (span.start - likely.end));
  return middle(span);
}

/** Estimates how many comparisons are left. */
export function looksLeft(
  tiers: Tiers,
  answers: readonly Answer[],
  expected: Expectation | null,
): number {
  const span = open(tiers, answers);
  const left = expected ? overlap(span, expected.likely) : span;
  const { start, end } = left.start < left.end ? left : span;
  return Math.ceil(Math.log2(end - start + 1));
}

function middle({ start, end }: Span): number {
  return Math.floor((start + end) / 2);
}

function isWithin({ start, end }: Span, tier: number): boolean {
  return start <= tier && tier < end;
}

function overlap(a: Span, b: Span): Span {
  return { start: Math.max(a.start, b.start), end: Math.min(a.end, b.end) };
}
