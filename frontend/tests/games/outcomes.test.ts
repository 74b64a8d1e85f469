import { describe, expect, it } from "vitest";

import type { Measure, MeasuredValue } from "@/api/types";
import {
  describeCourse,
  describeResult,
  endSentence,
  imperfections,
  isLost,
} from "@/games/outcomes";

import { behaviour, recording } from "../support/data";
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
    const asksForSurvival = behaviour({ target: null, measures: [{ kind: "alive" }] });
    expect(imperfections(recording({ end: "fell" }), asksForSurvival, game)).toEqual([
      "it was lost: the pole fell",
    ]);
    const saysNothing = behaviour({ target: null });
    expect(imperfections(recording({ end: "fell" }), saysNothing, game)).toEqual([]);
  });
});

describe("the result of a game", () => {
  const score: Measure = { kind: "score", at_least: 10 };
  const met: MeasuredValue = { unit: "points", value: 12, known: true, met: true };

  it("is its targets, and the measures that it meets", () => {
    const game = recording({ targets: 1, strays: 2, measured: [met] });
    expect(describeResult(game, behaviour({ measures: [score] }), SPACE_INVADERS)).toBe(
      "1 of 2 targets, 2 strays, 1 of 1 measure met",
    );
  });

  it("says nothing of items without a target, and the score where there are none", () => {
    const game = recording({ targets: null, strays: null, score: 12 });
    const free = behaviour({ target: null });
    expect(describeResult(game, free, SPACE_INVADERS)).toBe("");
    expect(describeResult(game, free, PONG)).toBe("Score 12");
    expect(describeResult({ ...game, score: -2 }, free, PONG)).toBe("Score −2");
    expect(
      describeResult({ ...game, measured: [met] }, { ...free, measures: [score] }, SPACE_INVADERS),
    ).toBe("1 of 1 measure met");
  });
});
