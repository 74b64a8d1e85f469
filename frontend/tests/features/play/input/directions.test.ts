import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { directionsAt } from "@/features/play/input/directions";

describe("a thumb on the pad", () => {
  it.each([
    [1, 0, "right"],
    [0.6, 0.6, "right down"],
    [0, 0.9, "down"],
    [-0.5, 0.5, "left down"],
    [-1, 0, "left"],
    [-0.5, -0.6, "left up"],
    [0, -1, "up"],
    [0.7, -0.7, "right up"],
    [0.1, 0.1, ""],
  ])("at %d, %d holds %s", (x, y, held) => {
    expect(directionsAt(x, y).join(" ")).toBe(held);
  });

  it("never holds opposite directions", () => {
    const side = fc.double({ min: -2, max: 2, noNaN: true });
    fc.assert(
      fc.property(side, side, (x, y) => {
        const held = new Set(directionsAt(x, y));
        expect(held.has("left") && held.has("right")).toBe(false);
        expect(held.has("up") && held.has("down")).toBe(false);
      }),
    );
  });
});
