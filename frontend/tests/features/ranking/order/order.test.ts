import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { allPlaces, findPlace } from "@/features/ranking/board/places";
import {
  isTied,
  joinAbove,
  moveDown,
  movedBetween,
  moveUp,
  newTier,
  pairCount,
  place,
  placeAll,
  type Place,
  sameOrder,
  tierOf,
  type Tiers,
} from "@/features/ranking/order/order";

import { tiers } from "../../../support/tiers";

/** An order, a recording that is in it or new, and a place in it. */
const situation = tiers.chain((order) =>
  fc.record({
    order: fc.constant(order),
    id: fc.constantFrom(...order.flat(), 99),
    to: fc
      .constantFrom(...allPlaces(order))
      .map((to) => findPlace(to, order) ?? { kind: "tray" as const }),
  }),
);

function isSound(order: Tiers): boolean {
  const ids = order.flat();
  return order.every((tier) => tier.length > 0) && new Set(ids).size === ids.length;
}

/** An order without one recording. */
function without(order: Tiers, id: number): Tiers {
  return place(order, id, { kind: "tray" });
}

describe("putting several recordings somewhere", () => {
  const several = situation.chain(({ order, id, to }) =>
    fc.record({
      order: fc.constant(order),
      ids: fc.subarray([...new Set([...order.flat(), id])], { minLength: 1 }),
      to: fc.constant(to),
    }),
  );

  it("ties them with each other and leaves the others as they were", () => {
    fc.assert(
      fc.property(several, ({ order, ids, to }) => {
        const after = placeAll(order, ids, to);
        const others = (of: Tiers) => placeAll(of, ids, { kind: "tray" });
        expect(isSound(after)).toBe(true);
        expect(sameOrder(others(after), others(order))).toBe(true);
        const places = new Set(ids.map((id) => tierOf(after, id)));
        expect(places.size).toBe(1);
        expect(places.has(-1)).toBe(to.kind === "tray");
      }),
    );
  });
});

describe("putting a recording somewhere", () => {
  it("leaves a sound order that differs in nothing else", () => {
    fc.assert(
      fc.property(situation, ({ order, id, to }) => {
        const after = place(order, id, to);
        expect(isSound(after)).toBe(true);
        expect(sameOrder(without(after, id), without(order, id))).toBe(true);
        expect(tierOf(after, id) >= 0).toBe(to.kind !== "tray");
      }),
    );
  });

  it("twice is the same as once, by what surrounds it", () => {
    fc.assert(
      fc.property(situation, ({ order, id, to }) => {
        const once = place(order, id, to);
        const at = tierOf(once, id);
        const again: Place = isTied(once, id)
          ? { kind: "tier", tier: at }
          : to.kind === "tray"
            ? to
            : { kind: "gap", before: at };
        expect(sameOrder(place(once, id, again), once)).toBe(true);
      }),
    );
  });

  it("into a tier ties it with all that are there", () => {
    fc.assert(
      fc.property(situation, ({ order, id, to }) => {
        if (to.kind !== "tier") return;
        const others = (order[to.tier] ?? []).filter((other) => other !== id);
        const after = place(order, id, to);
        expect(others.every((other) => tierOf(after, other) === tierOf(after, id))).toBe(true);
      }),
    );
  });

  it("into a gap puts it alone, below all before and above all after", () => {
    fc.assert(
      fc.property(situation, ({ order, id, to }) => {
        if (to.kind !== "gap") return;
        const after = place(order, id, to);
        const at = tierOf(after, id);
        expect(after[at]).toEqual([id]);
        order.forEach((tier, index) => {
          for (const other of tier) {
            if (other === id) continue;
            expect(tierOf(after, other) < at).toBe(index < to.before);
          }
        });
      }),
    );
  });
});

describe("moving by buttons", () => {
  const chosen = tiers.chain((order) =>
    fc.record({ order: fc.constant(order), id: fc.constantFrom(...order.flat()) }),
  );

  it("up and then down comes back, but for a tie that was left", () => {
    fc.assert(
      fc.property(chosen, ({ order, id }) => {
        if (isTied(order, id) || tierOf(order, id) === 0) return;
        expect(sameOrder(moveDown(moveUp(order, id), id), order)).toBe(true);
      }),
    );
  });

  it("up often enough makes it the best, alone", () => {
    fc.assert(
      fc.property(chosen, ({ order, id }) => {
        let now = order;
        for (let i = 0; i < order.length + 1; i += 1) now = moveUp(now, id);
        expect(now[0]).toEqual([id]);
      }),
    );
  });

  it("down often enough makes it the worst, alone", () => {
    fc.assert(
      fc.property(chosen, ({ order, id }) => {
        let now = order;
        for (let i = 0; i < order.length + 1; i += 1) now = moveDown(now, id);
        expect(now.at(-1)).toEqual([id]);
      }),
    );
  });

  it("out of a tie stays next to those it was tied with", () => {
    expect(moveUp([[1], [2, 3]], 3)).toEqual([[1], [3], [2]]);
    expect(moveDown([[1], [2, 3], [4]], 2)).toEqual([[1], [3], [2], [4]]);
    expect(newTier([[1], [2, 3], [4]], 2)).toEqual([[1], [3], [2], [4]]);
  });

  it("joins the tier above, and the best has none to join", () => {
    expect(joinAbove([[1], [2], [3]], 2)).toEqual([[1, 2], [3]]);
    expect(joinAbove([[1], [2]], 1)).toEqual([[1], [2]]);
  });

  it("ranks what is unranked as the worst", () => {
    expect(newTier([[1], [2]], 9)).toEqual([[1], [2], [9]]);
    expect(moveUp([[1]], 9)).toEqual([[1]]);
  });
});

describe("counting and comparing", () => {
  it("n tiers of one give n (n - 1) / 2 pairs", () => {
    fc.assert(
      fc.property(fc.integer({ min: 1, max: 60 }), (n) => {
        const order = Array.from({ length: n }, (_, id) => [id]);
        expect(pairCount(order)).toBe((n * (n - 1)) / 2);
      }),
    );
  });

  it("counts each pair of recordings in different tiers once", () => {
    fc.assert(
      fc.property(tiers, (order) => {
        const ids = order.flat();
        const pairs = ids.flatMap((a) => ids.filter((b) => tierOf(order, a) < tierOf(order, b)));
        expect(pairCount(order)).toBe(pairs.length);
      }),
    );
  });

  it("names the one recording that was moved", () => {
    fc.assert(
      fc.property(situation, ({ order, id, to }) => {
        const after = place(order, id, to);
        const moved = movedBetween(order, after);
        // Exchanging two neighbours moves either of them.
        expect(moved.size).toBe(sameOrder(order, after) ? 0 : 1);
      }),
    );
    expect([...movedBetween([[1], [2], [3]], [[2], [3]])]).toEqual([1]);
    expect([...movedBetween([[1], [2], [3], [4]], [[4], [1], [2], [3]])]).toEqual([4]);
  });

  it("finds no difference in the order within a tier", () => {
    expect(sameOrder([[1, 2], [3]], [[2, 1], [3]])).toBe(true);
    expect(sameOrder([[1, 2], [3]], [[1], [2, 3]])).toBe(false);
  });
});
