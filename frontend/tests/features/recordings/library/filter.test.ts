import fc from "fast-check";
import { describe, expect, it } from "vitest";

import {
  filtered,
  EVERYTHING,
  type Filter,
  isNarrow,
  ORDERS,
  readFilter,
  SHOWN,
  SOURCES,
  VERIFIED,
  writeFilter,
} from "@/features/recordings/library/filter";

import { recording } from "../../../support/data";

const games = [
  recording({ id: 4, targets: 2, strays: 1, perfect: true, ranked: true, counters: { shots: 9 } }),
  recording({ id: 3, targets: 2, strays: 0, player: "Bo", n_frames: 300, counters: { shots: 2 } }),
  recording({
    id: 2,
    targets: 0,
    strays: 3,
    source: "scripted",
    player: null,
    counters: { shots: 5 },
  }),
  recording({ id: 1, targets: 1, strays: 0, verification: "failed", deleted: true }),
];

function ids(change: Partial<Filter>): number[] {
  return filtered(games, { ...EVERYTHING, ...change }).map(({ id }) => id);
}

describe("the library's filter", () => {
  it("leaves out the deleted ones unless they are asked for", () => {
    expect(ids({})).toEqual([4, 3, 2]);
    expect(ids({ show: "deleted" })).toEqual([1]);
  });

  it("lets through what fits in every respect", () => {
    expect(ids({ show: "perfect" })).toEqual([4]);
    expect(ids({ show: "unranked" })).toEqual([3, 2]);
    expect(ids({ source: "scripted" })).toEqual([2]);
    expect(ids({ number: "3" })).toEqual([3]);
    expect(ids({ player: "Bo" })).toEqual([3]);
    expect(ids({ hits: 2 })).toEqual([4, 3]);
    expect(ids({ hits: 2, strays: 0 })).toEqual([3]);
    expect(ids({ verified: "no" })).toEqual([]);
    expect(ids({ verified: "no", show: "deleted" })).toEqual([1]);
  });

  it("counts aliens where there is no target", () => {
    const free = [recording({ id: 8, targets: null, strays: null, hits: [] })];
    expect(filtered(free, { ...EVERYTHING, hits: 1 })).toEqual([]);
    expect(filtered(free, { ...EVERYTHING, strays: 0 })).toHaveLength(1);
  });

  it("orders", () => {
    expect(ids({ order: "oldest" })).toEqual([2, 3, 4]);
    expect(ids({ order: "targets" })).toEqual([3, 4, 2]);
    expect(ids({ order: "strays" })).toEqual([3, 4, 2]);
    expect(ids({ order: "longest" })).toEqual([4, 2, 3]);
    expect(ids({ order: "shots" })).toEqual([3, 2, 4]);
  });

  it("survives its way through an address", () => {
    const filters = fc.record({
      show: fc.constantFrom(...SHOWN),
      source: fc.option(fc.constantFrom(...SOURCES)),
      player: fc.option(fc.string({ minLength: 1, unit: "grapheme" })),
      verified: fc.option(fc.constantFrom(...VERIFIED)),
      hits: fc.option(fc.nat({ max: 36 })),
      number: fc.option(fc.nat({ max: 99_999 }).map(String)),
      strays: fc.option(fc.nat({ max: 36 })),
      order: fc.constantFrom(...ORDERS),
    });
    fc.assert(
      fc.property(filters, (filter) => {
        const address = writeFilter(filter).toString();
        expect(readFilter(new URLSearchParams(address))).toEqual(filter);
      }),
    );
  });

  it("takes no notice of nonsense in an address, and says nothing of what is usual", () => {
    const nonsense = new URLSearchParams("show=x&source=me&hits=-1&strays=2.5&order=");
    expect(readFilter(nonsense)).toEqual(EVERYTHING);
    expect(writeFilter(EVERYTHING).toString()).toBe("");
    expect(isNarrow({ ...EVERYTHING, order: "oldest" })).toBe(false);
    expect(isNarrow({ ...EVERYTHING, strays: 0 })).toBe(true);
  });
});
