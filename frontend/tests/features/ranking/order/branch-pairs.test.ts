import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { judge, openPairs } from "@/features/ranking/order/branch-pairs";

import { recording } from "../../../support/data";

const BEFORE = recording({ id: 5 });
const AFTER = recording({ id: 6, parent: { recording_id: 5, number: 5, frame: 300 } });
const BY_ID = new Map([BEFORE, AFTER, recording({ id: 1 })].map((one) => [one.id, one]));
const PAIR = { before: BEFORE, after: AFTER, frame: 300 };

describe("pairs to compare", () => {
  it("are those of which one goes on from the other, until both are ranked", () => {
    expect(openPairs([[1]], [6, 5], BY_ID)).toEqual([PAIR]);
    expect(openPairs([[1], [5]], [6], BY_ID)).toEqual([PAIR]);
    expect(openPairs([[1], [5], [6]], [], BY_ID)).toEqual([]);
  });

  it("are none where one can't be ranked", () => {
    expect(openPairs([[1]], [6], BY_ID)).toEqual([]);
    expect(openPairs([], [6], new Map([[6, AFTER]]))).toEqual([]);
  });

  it("come newest first", () => {
    const newer = recording({ id: 9, parent: { recording_id: 6, number: 6, frame: 40 } });
    const found = openPairs([], [9, 6, 5], new Map([...BY_ID, [9, newer]]));
    expect(found.map(({ after }) => after.id)).toEqual([9, 6]);
  });
});

describe("judging a pair", () => {
  it("puts the missing one right beside the ranked one", () => {
    expect(judge([[1], [5], [2]], PAIR, "after")).toEqual([[1], [6], [5], [2]]);
    expect(judge([[1], [5], [2]], PAIR, "before")).toEqual([[1], [5], [6], [2]]);
    expect(judge([[1], [6], [2]], PAIR, "after")).toEqual([[1], [6], [5], [2]]);
    expect(judge([[1], [6], [2]], PAIR, "before")).toEqual([[1], [5], [6], [2]]);
    expect(judge([[1], [5], [2]], PAIR, "equal")).toEqual([[1], [5, 6], [2]]);
  });

  it("puts both to the end if neither is ranked", () => {
    expect(judge([[1]], PAIR, "after")).toEqual([[1], [6], [5]]);
    expect(judge([[1]], PAIR, "before")).toEqual([[1], [5], [6]]);
    expect(judge([], PAIR, "equal")).toEqual([[6, 5]]);
  });

  it("leaves the others in their order", () => {
    const others = fc.uniqueArray(fc.integer({ min: 10, max: 99 }), { maxLength: 8 });
    const verdict = fc.constantFrom("after" as const, "before" as const, "equal" as const);
    fc.assert(
      fc.property(others, fc.nat(8), verdict, (ids, at, judged) => {
        const place = Math.min(at, ids.length);
        const tiers = [...ids.slice(0, place), 5, ...ids.slice(place)].map((id) => [id]);
        const next = judge(tiers, PAIR, judged);
        expect(next.flat().filter((id) => id >= 10)).toEqual(ids);
        expect(next.flat()).toHaveLength(ids.length + 2);
      }),
    );
  });
});
