import { describe, expect, it } from "vitest";

import type { Measure, MeasuredValue } from "@/api/types";
import {
  boundText,
  measuredText,
  measureSentence,
  meanValue,
  metText,
  unitOf,
} from "@/games/measures";

import { PONG, SPACE_INVADERS } from "../support/games";

const UP: Measure = { kind: "region", thing: "player", area: [0, 34, 160, 114], at_least: 0.9 };

function value(of: number | null, met: boolean | null, known = true): MeasuredValue {
  return { value: of, met, known, unit: "share" };
}

describe("the sentence of a measure", () => {
  it.each<[Measure, string]>([
    [UP, "Green paddle in the area 0, 34 to 160, 114: at least 90% of the time"],
    [
      { ...UP, area: [0, 0, 160, 105] },
      "Green paddle in the upper 50% of the screen: at least 90% of the time",
    ],
    [
      { ...UP, area: [0, 105, 160, 210] },
      "Green paddle in the lower 50% of the screen: at least 90% of the time",
    ],
    [
      { ...UP, area: [0, 0, 40, 210] },
      "Green paddle in the left 25% of the screen: at least 90% of the time",
    ],
    [
      { ...UP, area: [120, 0, 160, 210] },
      "Green paddle in the right 25% of the screen: at least 90% of the time",
    ],
    [
      { kind: "nearness", thing: "player", other: "ball", distance_px: 12, axes: "y" },
      "Green paddle and ball at most 12 px apart in height",
    ],
    [
      { kind: "rate", button: "fire", per: "second", at_most: 1.5 },
      "Button “fire” pressed: at most 1.50 a second",
    ],
    [
      { kind: "rate", action: "LEFTFIRE", per: "time", at_most: 0.5 },
      "Action LEFTFIRE held: at most 50% of the time",
    ],
    [{ kind: "score", at_least: 100, at_most: 500 }, "Score: between 100 and 500"],
    [{ kind: "alive" }, "Alive at the end"],
    [{ kind: "length", at_least: 10 }, "Length of the game: at least 10.0\u00a0s"],
  ])("of %j is %j", (measure, sentence) => {
    expect(measureSentence(measure, PONG)).toBe(sentence);
  });

  it("names what is taken and counted in the game", () => {
    const cells: [number, number][] = [
      [0, 0],
      [1, 0],
    ];
    expect(measureSentence({ kind: "items", cells, at_least: 2 }, SPACE_INVADERS)).toBe(
      "Aliens hit, of 2 that count: at least 2",
    );
    expect(measureSentence({ kind: "counter", counter: "shots", at_most: 9 }, SPACE_INVADERS)).toBe(
      "Missiles fired: at most 9",
    );
    const seaquest = { ...PONG, tallies: { divers: "divers picked up" } };
    expect(measureSentence({ kind: "counter", counter: "divers" }, seaquest)).toBe(
      "Divers picked up",
    );
  });

  it("shows a thing of an unknown game by the server's name", () => {
    const game = { ...PONG, things: { basket: "basket" } };
    expect(measureSentence({ ...UP, thing: "basket" }, game)).toMatch(/^Basket in the area/);
  });
});

describe("the value of a measure", () => {
  it("is in its unit, or says why there is none", () => {
    expect(measuredText(value(0.876, false), UP)).toBe("88% of the time");
    expect(measuredText(value(null, null, false), UP)).toBe("being measured…");
    expect(measuredText(value(null, null), UP)).toBe("–");
    expect(measuredText(value(1, true), { kind: "alive" })).toBe("yes");
    expect(measuredText(value(0.5, true), { kind: "order", sequences: [] })).toBe("50%");
  });

  it("is a share of games as a mean of yes and no", () => {
    expect(meanValue(0.75, { kind: "alive" })).toBe("75%");
    expect(meanValue(3.25, { kind: "counter", counter: "shots" })).toBe("3.3");
  });

  it("has the unit that the server tells", () => {
    expect(unitOf({ kind: "rate", button: "fire", per: "time" })).toBe("share");
    expect(unitOf({ kind: "rate", button: "fire", per: "second" })).toBe("per_second");
    expect(boundText({ kind: "score" })).toBe("");
  });
});

describe("how many measures a game meets", () => {
  const measures: Measure[] = [UP, { kind: "alive" }, { kind: "score" }];

  it("counts those with a bound", () => {
    const values = [value(0.95, true), value(0, false), value(30, null)];
    expect(metText(values, measures)).toBe("1 of 2 measures met");
    expect(metText([value(30, null)], [{ kind: "score" }])).toBe("");
    expect(metText([], [])).toBe("");
  });

  it("waits until all are measured", () => {
    expect(metText([value(null, null, false), value(1, true)], measures)).toBe("being measured…");
  });
});
