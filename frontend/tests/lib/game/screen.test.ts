import fc from "fast-check";
import { describe, expect, it, vi } from "vitest";

import { paletteWords, ScreenPainter, screenScale } from "@/lib/game/screen";

const CONSOLE = { width: 160, height: 210, pixel_aspect: 12 / 7 };
const SQUARE = { width: 600, height: 400, pixel_aspect: 1 };

describe("the scale of the game's pixels", () => {
  it("is whole, fits, and is near the shape of the console's pixels where it can be", () => {
    const room = (min: number) => fc.integer({ min, max: 5000 });
    fc.assert(
      fc.property(room(160), room(210), (width, height) => {
        const { x, y } = screenScale(width, height, CONSOLE);
        expect(160 * x).toBeLessThanOrEqual(width + 1e-6);
        expect(210 * y).toBeLessThanOrEqual(height + 1e-6);
        expect(Number.isInteger(x) && Number.isInteger(y)).toBe(true);
        if (width < 320) return;
        expect(x / y).toBeGreaterThanOrEqual(1.5);
        expect(x / y).toBeLessThanOrEqual(2);
      }),
    );
  });

  it.each([
    [320, 210, { x: 2, y: 1 }],
    [900, 700, { x: 5, y: 3 }],
    [500, 500, { x: 3, y: 2 }],
  ])("in %i by %i is %o", (width, height, scale) => {
    expect(screenScale(width, height, CONSOLE)).toEqual(scale);
  });

  it.each([
    [1300, 900, { x: 2, y: 2 }],
    [700, 700, { x: 1, y: 1 }],
    [300, 900, { x: 0.5, y: 0.5 }],
  ])("keeps square pixels square in %i by %i, reduced where there is no room", (...args) => {
    const [width, height, scale] = args;
    expect(screenScale(width, height, SQUARE)).toEqual(scale);
  });

  it("never shrinks as the room grows", () => {
    fc.assert(
      fc.property(fc.nat(3000), fc.nat(3000), fc.nat(500), (width, height, more) => {
        expect(screenScale(width + more, height + more, CONSOLE).y).toBeGreaterThanOrEqual(
          screenScale(width, height, CONSOLE).y,
        );
      }),
    );
  });
});

describe("a painter", () => {
  it("draws colours as they are, and nothing before it knows their format", () => {
    const image = { width: 2, height: 1, data: new Uint8ClampedArray(8) };
    const context = { createImageData: () => image, putImageData: vi.fn() };
    const canvas = { getContext: () => context } as unknown as HTMLCanvasElement;
    const painter = new ScreenPainter(canvas);
    painter.draw(new Uint8Array(6));
    expect(context.putImageData).not.toHaveBeenCalled();
    painter.setFormat({ width: 2, height: 1, palette: null });
    expect([canvas.width, canvas.height]).toEqual([2, 1]);
    painter.draw(Uint8Array.of(1, 2, 3, 250, 128, 0));
    expect([...image.data]).toEqual([1, 2, 3, 255, 250, 128, 0, 255]);
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
