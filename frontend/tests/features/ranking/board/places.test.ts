import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { allPlaces, describePlace } from "@/features/ranking/board/places";

import { tiers } from "../../../support/tiers";

describe("the places of a board", () => {
  it("have a name each", () => {
    fc.assert(
      fc.property(tiers, (order) => {
        const names = allPlaces(order).map((to) => describePlace(to, order));
        expect(new Set(names).size).toBe(names.length);
      }),
    );
    expect(describePlace("gap-1", [[1], [2]])).toBe("new tier between tiers 1 and 2");
    expect(describePlace("tier-0", [[1], [2]])).toBe("tier 1 of 2, with 1 recording");
  });
});
