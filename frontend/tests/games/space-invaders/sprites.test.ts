import { describe, expect, it } from "vitest";

import { spritePath } from "@/games/space-invaders/sprites";

describe("the sprites", () => {
  it("differ from row to row, within 8 by 8 pixels", () => {
    const paths = [0, 1, 2, 3, 4, 5].map((row) => spritePath(row, 0, 0));
    expect(new Set(paths).size).toBe(6);
    for (const path of paths) {
      for (const [, x, y, length] of path.matchAll(/M(\d+) (\d+)h(\d+)/g)) {
        expect(Number(x) + Number(length)).toBeLessThanOrEqual(8);
        expect(Number(y)).toBeLessThan(8);
      }
    }
    expect(() => spritePath(6, 0, 0)).toThrow(RangeError);
  });
});
