import { describe, expect, it } from "vitest";

import {
  describeCourse,
  describeScore,
  endSentence,
  imperfections,
  isLost,
} from "@/games/outcomes";

import { recording } from "../support/data";
import { CART_POLE, PONG, SPACE_INVADERS } from "../support/games";

describe("the course of a game", () => {
  it("counts a step that its end cut short, and takes the time from the frames", () => {
    const lost = { n_frames: 85, n_steps: 22, end: "hit", state: "kept" } as const;
    expect(describeCourse(lost, SPACE_INVADERS)).toBe("22 steps, 1.4\u00a0s, hit by a bomb");
    const over = { n_frames: 85, n_steps: 85, end: "over", state: "kept" } as const;
    expect(describeCourse(over, CART_POLE)).toBe("85 steps, 1.7\u00a0s, the game was over");
  });

  it("says that its time was over by the game's own number of steps", () => {
    const whole = { n_frames: 500, n_steps: 500, end: "steps", state: "kept" } as const;
    expect(describeCourse(whole, CART_POLE)).toBe("survived all 500 steps, 10.0\u00a0s");
  });

  it("is the server's sentence where the page has no words for an end", () => {
    const ends = [{ name: "fell", kind: "death", sentence: "the pole fell" }];
    const game = { ...CART_POLE, ends };
    expect(endSentence({ reason: "fell", frame: 100 }, game)).toBe(
      "The pole fell after 2.0\u00a0s",
    );
    expect(isLost("fell", game)).toBe(true);
    expect(imperfections(recording({ end: "fell" }), null, game)).toEqual([
      "it was lost: the pole fell",
    ]);
  });
});

describe("the result of a game", () => {
  it("is what was taken where there are items, else the score", () => {
    const game = recording({ targets: null, strays: null, score: 12 });
    expect(describeScore(game, null, SPACE_INVADERS)).toBe("1 alien hit");
    expect(describeScore(game, null, PONG)).toBe("Score 12");
    expect(describeScore({ ...game, score: -2 }, null, PONG)).toBe("Score −2");
  });

  it("names the items of a game that the page does not know", () => {
    const items = { ...SPACE_INVADERS.items, singular: "brick", plural: "bricks" };
    const game = { ...PONG, items: items as NonNullable<typeof SPACE_INVADERS.items> };
    const broken = recording({ targets: null, strays: null });
    expect(describeScore(broken, null, game)).toBe("1 brick");
  });
});
