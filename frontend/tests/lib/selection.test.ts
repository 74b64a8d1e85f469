import { describe, expect, it } from "vitest";

import { selectedBy, selecting } from "@/lib/selection";

describe("what is selected on the page that is led to", () => {
  it("is what the state says", () => {
    expect(selectedBy(selecting([3, 4]))).toEqual([3, 4]);
  });

  it.each([[null], ["3"], [{}], [{ selected: 3 }], [{ selected: ["3"] }]])(
    "is nothing with a state of %j",
    (state) => {
      expect(selectedBy(state)).toEqual([]);
    },
  );
});
