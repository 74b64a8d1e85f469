import fc from "fast-check";
import { describe, expect, it } from "vitest";

import type { GameOpinion } from "@/api/types";
import {
  type Answer,
  type Expectation,
  expectationOf,
  looksLeft,
  nextTier,
  placeAfter,
} from "@/features/ranking/comparing/search";
import { place, sameOrder, tierOf, type Tiers } from "@/features/ranking/order/order";

import { tiers } from "../../../support/tiers";

const NEW = 99;

/** An order, and where in it the recording belongs: at 2 k above tier k, at 2 k + 1 in it. */
const situation = tiers.chain((order) =>
  fc.record({ order: fc.constant(order), at: fc.integer({ min: 0, max: 2 * order.length }) }),
);

/** The same, with what is expected of the recording, rightly or not. */
const expecting = situation.chain(({ order, at }) =>
  fc
    .uniqueArray(fc.integer({ min: 0, max: order.length }), { minLength: 2, maxLength: 2 })
    .map((ends) => ends.sort((a, b) => a - b) as [number, number])
    .chain(([start, end]) =>
      fc.integer({ min: start, max: end - 1 }).map((tier): Expectation => ({
        tier,
        likely: { start, end },
      })),
    )
    .map((expected) => ({ order, at, expected })),
);

/** Answers as somebody who knows where the recording belongs until it has its place. */
function search(order: Tiers, at: number, expected: Expectation | null) {
  const answers: Answer[] = [];
  const asked: number[] = [];
  for (;;) {
    const to = placeAfter(order, answers);
    if (to) return { result: place(order, NEW, to), asked };
    const tier = nextTier(order, answers, expected);
    if (tier === null) throw new Error("Nothing to compare with, and no place.");
    const here = 2 * tier + 1;
    const verdict = at === here ? "equal" : at < here ? "better" : "worse";
    asked.push(tier);
    answers.push({ opponent: order[tier]?.[0] ?? 0, verdict });
  }
}

/** The order with the recording where it belongs. */
function belonging(order: Tiers, at: number): Tiers {
  const half = Math.floor(at / 2);
  return place(
    order,
    NEW,
    at % 2 === 1 ? { kind: "tier", tier: half } : { kind: "gap", before: half },
  );
}

const bits = (n: number) => Math.ceil(Math.log2(n + 1));
const oneEach = (n: number): Tiers => Array.from({ length: n }, (_, index) => [index + 1]);

describe("searching a place without an opinion", () => {
  it("finds the right one with at most ceil(log2(n + 1)) comparisons", () => {
    fc.assert(
      fc.property(situation, ({ order, at }) => {
        const { result, asked } = search(order, at, null);
        expect(sameOrder(result, belonging(order, at))).toBe(true);
        expect(asked.length).toBeLessThanOrEqual(bits(order.length));
      }),
    );
  });

  it("takes no more in any order of up to 40 tiers", () => {
    for (let n = 1; n <= 40; n += 1) {
      for (let at = 0; at <= 2 * n; at += 1)
        expect(search(oneEach(n), at, null).asked.length).toBeLessThanOrEqual(bits(n));
    }
  });

  it("says before each comparison how many may be left", () => {
    expect(looksLeft(oneEach(7), [], null)).toBe(3);
    expect(looksLeft(oneEach(7), [{ opponent: 4, verdict: "better" }], null)).toBe(2);
    expect(looksLeft(oneEach(1), [], null)).toBe(1);
  });
});

describe("searching a place from where an opinion expects it", () => {
  it("finds the right one whatever was expected, never asking about a tier twice", () => {
    fc.assert(
      fc.property(expecting, ({ order, at, expected }) => {
        const { result, asked } = search(order, at, expected);
        expect(sameOrder(result, belonging(order, at))).toBe(true);
        expect(new Set(asked).size).toBe(asked.length);
        expect(asked.length).toBeLessThanOrEqual(2 * bits(order.length) + 1);
      }),
    );
  });

  it("begins at the expected tier, and ends there if that is right", () => {
    fc.assert(
      fc.property(expecting, ({ order, expected }) => {
        expect(search(order, 2 * expected.tier + 1, expected).asked).toEqual([expected.tier]);
      }),
    );
  });

  it("keeps to the likely tiers as long as answers do", () => {
    fc.assert(
      fc.property(expecting, ({ order, at, expected }) => {
        const { start, end } = expected.likely;
        if (at <= 2 * start || at >= 2 * end) return;
        const { asked } = search(order, at, expected);
        expect(asked.every((tier) => start <= tier && tier < end)).toBe(true);
        expect(asked.length).toBeLessThanOrEqual(bits(end - start) + 1);
      }),
    );
  });

  it("goes further away the longer answers contradict it", () => {
    const expected = { tier: 30, likely: { start: 30, end: 31 } };
    expect(search(oneEach(31), 0, expected).asked).toEqual([30, 29, 27, 23, 15, 0]);
    const best = { tier: 0, likely: { start: 0, end: 1 } };
    expect(search(oneEach(31), 62, best).asked).toEqual([0, 1, 3, 7, 15, 30]);
  });
});

describe("answers", () => {
  it("stay true when the order changes elsewhere", () => {
    const answers: Answer[] = [{ opponent: 2, verdict: "worse" }];
    expect(nextTier([[1], [2], [3]], answers, null)).toBe(2);
    expect(nextTier([[2], [1], [3]], answers, null)).toBe(2);
    expect(nextTier([[1], [3]], answers, null)).toBe(1);
    expect(placeAfter([[1], [3], [2]], answers)).toEqual({ kind: "gap", before: 3 });
  });

  it("that contradict each other count from the newest", () => {
    const answers: Answer[] = [
      { opponent: 1, verdict: "better" },
      { opponent: 3, verdict: "worse" },
    ];
    expect(placeAfter([[1], [2], [3]], answers)).toEqual({ kind: "gap", before: 3 });
  });
});

describe("the expectation of an opinion", () => {
  const opinion = (place: number, best: number, worst: number): GameOpinion => ({
    recording_id: NEW,
    place,
    best_place: best,
    worst_place: worst,
    tier: 0,
    best_tier: 0,
    worst_tier: 0,
    contradicted_by: [],
  });

  it("is the tier of its place, and those of its interval", () => {
    const order = [[1], [2, 3], [4]];
    expect(expectationOf(order, opinion(0.5, 0.25, 0.8))).toEqual({
      tier: 1,
      likely: { start: 0, end: 3 },
    });
    expect(expectationOf(order, opinion(0.3, 0.26, 0.75))).toEqual({
      tier: 1,
      likely: { start: 1, end: 2 },
    });
  });

  it("is within the order", () => {
    const share = fc.double({ min: 0, max: 1, noNaN: true });
    fc.assert(
      fc.property(tiers, fc.tuple(share, share, share), (order, shares) => {
        const [best, middle, worst] = [...shares].sort((a, b) => a - b) as [number, number, number];
        const { tier, likely } = expectationOf(order, opinion(middle, best, worst));
        expect(order[tier]).toBeDefined();
        expect(likely.start).toBeLessThanOrEqual(tier);
        expect(tier).toBeLessThan(likely.end);
        expect(likely.end).toBeLessThanOrEqual(order.length);
        expect(tierOf(order, order[tier]?.[0] ?? 0)).toBe(tier);
      }),
    );
  });
});
