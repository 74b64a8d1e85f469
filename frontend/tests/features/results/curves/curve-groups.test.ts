import { describe, expect, it } from "vitest";

import { curveGroups } from "@/features/results/curves/curve-groups";

describe("the imitator's curves", () => {
  const titlesOf = (imitator: Record<string, [number, number][]>) =>
    curveGroups({ imitator })[0]?.charts.map(({ title }) => title);

  it("show the expert's share and the agreement with it for DAgger", () => {
    const charts = curveGroups({
      imitator: {
        expert_share: [
          [300, 1],
          [600, 0.5],
        ],
        agreement: [[600, 0.7]],
      },
    })[0]?.charts;
    expect(charts?.map(({ title }) => title)).toEqual(["Agreement with the expert (DAgger)"]);
    expect(charts?.[0]?.curves).toMatchObject([
      { name: "most probable action", dashed: false, points: [[600, 0.7]] },
      { name: "steps by the expert", dashed: true },
    ]);
  });

  it("show how often GAIL's discriminator is right", () => {
    expect(titlesOf({ discriminator_accuracy: [[2048, 0.8]] })).toEqual([
      "Discriminator accuracy (GAIL)",
    ]);
  });

  it("show neither for PPO on the learned reward", () => {
    expect(titlesOf({ entropy: [[2048, 0.8]] })).toEqual(["Indecision (entropy)"]);
  });
});

describe("the curves", () => {
  it("are those for which there are points, each stage in its colour", () => {
    const groups = curveGroups({
      imitator: { hits: [[1, 2]], strays: [[1, 0]], entropy: [] },
      clone: { loss: [[1, 2]] },
    });
    expect(groups.map((group) => group.stage)).toEqual(["imitator", "clone"]);
    expect(groups[0]?.charts.map((chart) => chart.title)).toEqual(["Hits per game"]);
    expect(groups[0]?.charts[0]?.curves).toMatchObject([
      { name: "targets", colour: "var(--imitator)", dashed: false },
      { name: "strays", colour: "var(--imitator)", dashed: true },
    ]);
    expect(groups[1]?.charts[0]?.curves[0]?.colour).toBe("var(--clone)");
  });
});
