/** Paints screens on a canvas and computes their scale. */
import { SCREEN_HEIGHT, SCREEN_WIDTH } from "./codec";

export type Palette = readonly (readonly [red: number, green: number, blue: number])[];

const LITTLE_ENDIAN = new Uint8Array(new Uint32Array([1]).buffer)[0] === 1;

/** Converts a palette to one 32-bit RGBA word per index, in native byte order. */
export function paletteWords(palette: Palette): Uint32Array {
  const words = new Uint32Array(256);
  palette.forEach(([red, green, blue], value) => {
    words[value] = LITTLE_ENDIAN
      ? (0xff000000 | (blue << 16) | (green << 8) | red) >>> 0
      : ((red << 24) | (green << 16) | (blue << 8) | 0xff) >>> 0;
  });
  return words;
}

/** Draws screens on a canvas of 160x210 pixels, which CSS enlarges. */
export class ScreenPainter {
  private readonly context: CanvasRenderingContext2D;
  private readonly image: ImageData;
  private readonly words: Uint32Array;
  private palette: Uint32Array = new Uint32Array(256);

  constructor(canvas: HTMLCanvasElement) {
    const context = canvas.getContext("2d", { alpha: false });
    if (!context) throw new Error("This browser can't draw on a canvas.");
    canvas.width = SCREEN_WIDTH;
    canvas.height = SCREEN_HEIGHT;
    this.context = context;
    this.image = context.createImageData(SCREEN_WIDTH, SCREEN_HEIGHT);
    this.words = new Uint32Array(this.image.data.buffer);
  }

  setPalette(palette: Palette): void {
    this.palette = paletteWords(palette);
  }

  /** Draws palette indices (210 x 160, row by row). */
  draw(pixels: Uint8Array): void {
    const { words, palette } = this;
    for (let i = 0; i < words.length; i += 1) words[i] = palette[pixels[i] ?? 0] ?? 0;
    this.context.putImageData(this.image, 0, 0);
  }
}

/** Device pixels per pixel of the game. */
interface Scale {
  readonly x: number;
  readonly y: number;
}

/** Aspect ratio of the console's pixels on a television, width by height. */
const PIXEL_ASPECT = 12 / 7;
const NARROWEST = 1.5;
const WIDEST = 2;

/**
 * Returns the largest integer scale that fits, close to the console's pixel aspect ratio.
 *
 * @param width Available device pixels.
 * @param height Available device pixels.
 */
export function screenScale(width: number, height: number): Scale {
  const mostY = Math.max(1, Math.floor(height / SCREEN_HEIGHT));
  const mostX = Math.max(1, Math.floor(width / SCREEN_WIDTH));
  for (let y = mostY; y >= 1; y -= 1) {
    let best = 0;
    for (let x = Math.ceil(NARROWEST * y); x <= Math.min(mostX, WIDEST * y); x += 1) {
      if (best === 0 || aspectError(x / y) < aspectError(best / y)) best = x;
    }
    if (best > 0) return { x: best, y };
  }
  return { x: 1, y: 1 };
}

function aspectError(aspect: number): number {
  return Math.abs(Math.log(aspect / PIXEL_ASPECT));
}
