import { describe, expect, it } from "vitest";

import { actionInWords, lanesOf } from "@/features/recordings/detail/actions";

describe("actions", () => {
  const actions = [0, 4, 4, 2, 0, 5];

  it("are named by the frame that they led to", () => {
    expect(actionInWords(actions, 0)).toBe("the start");
    expect(actionInWords(actions, 1)).toBe("nothing");
    expect(actionInWords(actions, 2)).toBe("right and fire");
    expect(actionInWords(actions, 4)).toBe("right");
    expect(actionInWords(actions, 6)).toBe("left and fire");
    expect(actionInWords(actions, 7)).toBe("none");
  });

  it("say from which frame to which each key was held", () => {
    expect(lanesOf(actions)).toEqual([
      { name: "left", spans: [{ from: 6, to: 6 }] },
      { name: "right", spans: [{ from: 2, to: 4 }] },
      {
        name: "fire",
        spans: [
          { from: 2, to: 3 },
          { from: 6, to: 6 },
        ],
      },
    ]);
  });
});
