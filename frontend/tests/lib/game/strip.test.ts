import { describe, expect, it } from "vitest";

import { momentsOf } from "@/lib/game/strip";
import { CART_POLE, SPACE_INVADERS } from "../../support/games";

describe("the moments of a film strip", () => {
  it("are where tests/server/play/test_strip.py says", () => {
    const { whole, small } = momentsOf(SPACE_INVADERS);
    expect(whole.sheet).toEqual({ width: 2 * 160, height: 4 * 210 + 2 * 52 });
    expect([whole.top, small.top]).toEqual([0, 4 * 210]);
    expect(small.shape).toMatchObject({ width: 80, height: 52 });
  });

  it("are those that the server has reduced for a game with a large screen", () => {
    expect(momentsOf(CART_POLE).whole).toMatchObject({
      shape: { width: 300, height: 200 },
      sheet: { width: 2 * 300, height: 4 * 200 + 2 * 50 },
    });
  });
});
