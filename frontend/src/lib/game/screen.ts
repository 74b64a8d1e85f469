/** Paints screens on a canvas and computes their scale. */

export type Palette = readonly (readonly [red: number, green: number, blue: number])[];

/** How screens are sent: the size, and the colours of palette indices; null for RGB. */
export interface ScreenFormat {
  readonly width: number;
  readonly height: number;
  readonly palette: Palette | null;
}

/** The size of a game's screen, and the width of its pixels by their height. */
export interface ScreenShape {
  readonly width: number;
  readonly height: number;
  readonly pixel_aspect: number;
}

const LITTLE_ENDIAN = new Uint8Array(new Uint32Array([1]).buffer)[0] === 1;

/** Returns a colour as one 32-bit RGBA word, in native byte order. */
function word(red: number, green: number, blue: number): number {
  return LITTLE_ENDIAN
    ? (0xff000000 | (blue << 16) | (green << 8) | red) >>> 0
    : ((red << 24) | (green << 16) | (blue << 8) | 0xff) >>> 0;
}

/** Converts a palette to one word per index. */
export function paletteWords(palette: Palette): Uint32Array {
  const words = new Uint32Array(256);
  palette.forEach(([red, green, blue], value) => {
    words[value] = word(red, green, blue);
  });
  return words;
}

/** Draws screens on a canvas of their size, which CSS enlarges. */
export class ScreenPainter {
  private readonly canvas: HTMLCanvasElement;
  private readonly context: CanvasRenderingContext2D;
  private image: ImageData | null = null;
  private words = new Uint32Array(0);
  private palette: Uint32Array | null = null;

  constructor(canvas: HTMLCanvasElement) {
    const context = canvas.getContext("2d", { alpha: false });
    if (!context) throw new Error("This browser can't draw on a canvas.");
    this.canvas = canvas;
    this.context = context;
  }

  /** Prepares for screens of a format; before, nothing is drawn. */
  setFormat({ width, height, palette }: ScreenFormat): void {
    this.palette = palette && paletteWords(palette);
    if (this.image?.width === width && this.image.height === height) return;
    this.canvas.width = width;
    this.canvas.height = height;
    this.image = this.context.createImageData(width, height);
    this.words = new Uint32Array(this.image.data.buffer);
  }

  /** Draws palette indices or colours, row by row. */
  draw(pixels: Uint8Array): void {
    const { words, palette, image } = this;
    if (!image) return;
    if (palette) {
      for (let i = 0; i < words.length; i += 1) words[i] = palette[pixels[i] ?? 0] ?? 0;
    } else {
      for (let i = 0, at = 0; i < words.length; i += 1, at += 3)
        words[i] = word(pixels[at] ?? 0, pixels[at + 1] ?? 0, pixels[at + 2] ?? 0);
    }
    this.context.putImageData(image, 0, 0);
  }
}

/** Device pixels per pixel of the game. */
interface Scale {
  readonly x: number;
  readonly y: number;
}

/** How far the shape of a pixel may be off for the sake of whole device pixels, as a factor. */
const NARROWEST = 7 / 8;
const WIDEST = 7 / 6;

/**
 * Returns the largest scale of whole numbers that fits and is close to the shape of the game's
 * pixels; one to one where none is close, a fraction where the screen is larger than the box.
 *
 * @param width Available device pixels.
 * @param height Available device pixels.
 */
export function screenScale(width: number, height: number, screen: ScreenShape): Scale {
  const aspect = screen.pixel_aspect;
  const mostX = Math.floor(width / screen.width);
  for (let y = Math.floor(height / screen.height); y >= 1; y -= 1) {
    let best = 0;
    const widest = Math.min(mostX, Math.floor(WIDEST * aspect * y + TOLERANCE));
    for (let x = Math.max(1, Math.ceil(NARROWEST * aspect * y - TOLERANCE)); x <= widest; x += 1) {
      if (best === 0 || isCloser(x / y, best / y, aspect)) best = x;
    }
    if (best > 0) return { x: best, y };
  }
  if (mostX >= 1 && height >= screen.height) return { x: 1, y: 1 };
  const y = Math.min(height / screen.height, width / (screen.width * aspect));
  return { x: y * aspect, y };
}

const TOLERANCE = 1e-9;

function isCloser(ratio: number, otherRatio: number, aspect: number): boolean {
  return Math.abs(Math.log(ratio / aspect)) < Math.abs(Math.log(otherRatio / aspect));
}
