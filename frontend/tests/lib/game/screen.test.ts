import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { paletteWords, screenScale } from "@/lib/game/screen";

describe("the scale of the game's pixels", () => {
  it("is whole, fits, and is near the shape of the console's pixels", () => {
    const room = (min: number) => fc.integer({ min, max: 5000 });
    fc.assert(
      fc.property(room(160), room(210), (width, height) => {
        const { x, y } = screenScale(width, height);
        expect(Number.isInteger(x) && Number.isInteger(y)).toBe(true);
        expect(Math.min(x, y)).toBeGreaterThanOrEqual(1);
        if (x > 1 || y > 1) {
          expect(160 * x).toBeLessThanOrEqual(width);
          expect(210 * y).toBeLessThanOrEqual(height);
          expect(x / y).toBeGreaterThanOrEqual(1.5);
          expect(x / y).toBeLessThanOrEqual(2);
        }
      }),
    );
  });

  it.each([
    [320, 210, { x: 2, y: 1 }],
    [900, 700, { x: 5, y: 3 }],
    [500, 500, { x: 3, y: 2 }],
    [200, 800, { x: 1, y: 1 }],
  ])("in %i by %i is %o", (width, height, scale) => {
    expect(screenScale(width, height)).toEqual(scale);
  });

  it("never shrinks as the room grows", () => {
    fc.assert(
      fc.property(fc.nat(3000), fc.nat(3000), fc.nat(500), (width, height, more) => {
        expect(screenScale(width + more, height + more).y).toBeGreaterThanOrEqual(
          screenScale(width, height).y,
        );
      }),
    );
  });
});

describe("the palette", () => {
  it("becomes the bytes red, green, blue, opaque", () => {
    const words = paletteWords([
      [1, 2, 3],
      [255, 128, 0],
    ]);
    expect([...new Uint8Array(words.buffer).slice(0, 8)]).toEqual([1, 2, 3, 255, 255, 128, 0, 255]);
  });
});
