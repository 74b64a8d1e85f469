import fc from "fast-check";
import { describe, expect, it } from "vitest";

import {
  allPlaces,
  describePlace,
  describeStep,
  findPlace,
  gapPlace,
  tierPlace,
} from "@/features/ranking/board/places";

import { tiers } from "../../../support/tiers";

describe("the places of a board", () => {
  it("have a name each", () => {
    fc.assert(
      fc.property(tiers, (order) => {
        const names = allPlaces(order).map((to) => describePlace(to, order));
        expect(new Set(names).size).toBe(names.length);
      }),
    );
    expect(describePlace("gap-5", [[4], [5]])).toBe("new tier between tiers 1 and 2");
    expect(describePlace("tier-4", [[4], [5]])).toBe("tier 1 of 2, with 1 recording");
  });

  it("are those of the same recordings in another order", () => {
    const place = tierPlace([3]);
    expect(findPlace(place, [[1], [2], [3]])).toEqual({ kind: "tier", tier: 2 });
    expect(findPlace(place, [[3], [1], [2]])).toEqual({ kind: "tier", tier: 0 });
    expect(findPlace(gapPlace([3]), [[1], [3, 2]])).toEqual({ kind: "gap", before: 1 });
    expect(findPlace(gapPlace(), [[1], [3]])).toEqual({ kind: "gap", before: 2 });
    expect(findPlace(place, [[1], [2]])).toBeNull();
    expect(describePlace(place, [[1], [2]])).toBe("a place that is gone");
  });
});

describe("what an undo or redo changed", () => {
  const nameOf = (id: number) => `Recording ${id}`;

  it("is told by the places of the few games that moved", () => {
    expect(describeStep("undo", { from: [[4], [1], [2], [3]], to: [[1], [2], [3]] }, nameOf)).toBe(
      "Undone. Recording 4: unranked.",
    );
    expect(describeStep("redo", { from: [[1], [2], [3]], to: [[1, 3], [2]] }, nameOf)).toBe(
      "Redone. Recording 3: tier 1 of 2, tied with 1.",
    );
  });

  it("is counted where many moved, and told of the whole order where it was reversed", () => {
    const five = [[1], [2], [3], [4], [5]];
    expect(describeStep("undo", { from: five, to: [] }, nameOf)).toBe(
      "Undone. 5 recordings have other places.",
    );
    expect(describeStep("undo", { from: five, to: five.toReversed() }, nameOf)).toBe(
      "Undone. The order is reversed.",
    );
  });
});
