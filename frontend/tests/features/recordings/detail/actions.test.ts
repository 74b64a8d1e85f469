import { describe, expect, it } from "vitest";

import { describeAction, lanesOf } from "@/features/recordings/detail/actions";

describe("actions", () => {
  const actions = [0, 4, 4, 2, 0, 5];

  it("are named by the frame that they led to", () => {
    expect(describeAction(actions, 0)).toBe("the start");
    expect(describeAction(actions, 1)).toBe("nothing");
    expect(describeAction(actions, 2)).toBe("right and fire");
    expect(describeAction(actions, 4)).toBe("right");
    expect(describeAction(actions, 6)).toBe("left and fire");
    expect(describeAction(actions, 7)).toBe("none");
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
