import { describe, expect, it } from "vitest";

import { NOTHING, selectedOf, toggled } from "@/features/recordings/library/selection";

describe("the library's selection", () => {
  const shown = [9, 7, 5, 3];

  it("takes one in and out", () => {
    const one = toggled(NOTHING, shown, 7, false);
    expect(selectedOf(one, shown)).toEqual([7]);
    expect(selectedOf(toggled(one, shown, 7, false), shown)).toEqual([]);
  });

  it("takes a range in, in either direction, and out again", () => {
    const down = toggled(toggled(NOTHING, shown, 7, false), shown, 3, true);
    expect(selectedOf(down, shown)).toEqual([7, 5, 3]);
    const up = toggled(toggled(NOTHING, shown, 3, false), shown, 9, true);
    expect(selectedOf(up, shown)).toEqual(shown);
    expect(selectedOf(toggled(up, shown, 5, true), shown)).toEqual([3]);
  });

  it("never reaches what is not shown", () => {
    const all = toggled(toggled(NOTHING, shown, 9, false), shown, 3, true);
    expect(selectedOf(all, [5, 2])).toEqual([5]);
    expect(selectedOf(toggled(all, [5, 2], 2, true), [5, 2])).toEqual([5, 2]);
  });
});
