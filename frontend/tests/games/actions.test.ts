import { describe, expect, it } from "vitest";

import { actionName, actionsInOrder, describeAction, lanesOf } from "@/games/actions";

import { CART_POLE, MS_PACMAN, SPACE_INVADERS } from "../support/games";

describe("actions", () => {
  const actions = [0, 4, 4, 2, 0, 5];

  it("are named by the frame that they led to", () => {
    expect(describeAction(actions, 0, SPACE_INVADERS)).toBe("the start");
    expect(describeAction(actions, 1, SPACE_INVADERS)).toBe("nothing");
    expect(describeAction(actions, 2, SPACE_INVADERS)).toBe("right and fire");
    expect(describeAction(actions, 4, SPACE_INVADERS)).toBe("right");
    expect(describeAction(actions, 6, SPACE_INVADERS)).toBe("left and fire");
    expect(describeAction(actions, 7, SPACE_INVADERS)).toBe("none");
  });

  it("say from which frame to which each key was held", () => {
    expect(lanesOf(actions, SPACE_INVADERS)).toEqual([
      { button: "left", spans: [{ from: 6, to: 6 }] },
      { button: "right", spans: [{ from: 2, to: 4 }] },
      {
        button: "fire",
        spans: [
          { from: 2, to: 3 },
          { from: 6, to: 6 },
        ],
      },
    ]);
  });

  it("are named by the buttons of any game", () => {
    expect(actionName(7, MS_PACMAN)).toBe("right and down");
    expect(actionName(1, CART_POLE)).toBe("right");
    expect(actionName(9, CART_POLE)).toBe("action 9");
  });

  it("stand in order from left to right", () => {
    expect(actionsInOrder(SPACE_INVADERS)).toEqual([3, 5, 0, 1, 2, 4]);
    expect(actionsInOrder(CART_POLE)).toEqual([0, 1]);
  });
});
