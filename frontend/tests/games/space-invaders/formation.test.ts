import { describe, expect, it } from "vitest";

import {
  alienBox,
  alienGeometry,
  cellsLeft,
  formationOf,
  hitsUntil,
} from "@/games/space-invaders/formation";

const ALIENS = { width: 8, height: 10, column_px: 16, row_px: 18 };
const HITS = [
  { row: 0, column: 1, frame: 40 },
  { row: 1, column: 1, frame: 90 },
];

describe("the formation", () => {
  it("has the bottom row lowest and the first column at its left", () => {
    const at = { left: 23, top: 31 };
    expect(alienBox([5, 0], at, ALIENS)).toEqual({ left: 23, top: 31, width: 8, height: 10 });
    expect(alienBox([0, 5], at, ALIENS)).toEqual({ left: 103, top: 121, width: 8, height: 10 });
  });

  it("keeps its origin when its first columns are gone", () => {
    expect(alienBox([0, 5], { left: -60, top: 61 }, ALIENS)).toMatchObject({ left: 20, top: 151 });
  });

  it("loses an alien in the frame of its hit and regains it when the game is rewound", () => {
    expect([0, 39, 40, 89, 90, 500].map((frame) => hitsUntil(HITS, frame))).toEqual([
      0, 0, 1, 1, 2, 2,
    ]);
    const cells = [
      [0, 1],
      [1, 1],
      [2, 1],
    ] as const;
    expect(cellsLeft(cells, HITS, 0)).toEqual(cells);
    expect(cellsLeft(cells, HITS, 1)).toEqual([
      [1, 1],
      [2, 1],
    ]);
    expect(cellsLeft(cells, HITS, 2)).toEqual([[2, 1]]);
  });

  it("is read from the marks of a frame, also left of the screen", () => {
    expect(formationOf(Uint8Array.of(0, 31))).toEqual({ left: -96, top: 31 });
    expect(formationOf(Uint8Array.of(255, 31))).toEqual({ left: 159, top: 31 });
  });

  it("is that of its own overlay alone", () => {
    expect(alienGeometry({ painter: "bricks", geometry: ALIENS })).toBeNull();
    expect(alienGeometry({ painter: "alien-formation", geometry: ALIENS })).toEqual(ALIENS);
  });
});
