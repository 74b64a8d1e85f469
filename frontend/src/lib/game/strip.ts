/** Where the moments are in the picture of a film strip, which the server makes. */
import type { ScreenShape } from "./screen";

const ROWS = 4;
const COLUMNS = 2;
export const SMALL_ROWS = 2;
export const SMALL_COLUMNS = 4;

/** Moments of one size in a film strip, row by row, in its pixels. */
export interface Moments {
  /** Size of a moment. */
  readonly shape: ScreenShape;
  /** Size of the whole picture. */
  readonly sheet: { readonly width: number; readonly height: number };
  /** Where the first of them begins. */
  readonly top: number;
}

interface Filmed {
  readonly pixel_aspect: number;
  /** Sizes of the moments of its film strips. */
  readonly strip: {
    readonly width: number;
    readonly height: number;
    readonly small_width: number;
    readonly small_height: number;
  };
}

/** Returns the moments of a game's film strips as large as they are, and reduced. */
export function momentsOf({ strip, pixel_aspect }: Filmed): { whole: Moments; small: Moments } {
  const { width, height, small_width, small_height } = strip;
  const sheet = {
    width: Math.max(COLUMNS * width, SMALL_COLUMNS * small_width),
    height: ROWS * height + SMALL_ROWS * small_height,
  };
  return {
    whole: { shape: { width, height, pixel_aspect }, sheet, top: 0 },
    small: {
      // The server reduces them so that their pixels are about square.
      shape: { width: small_width, height: small_height, pixel_aspect: 1 },
      sheet,
      top: ROWS * height,
    },
  };
}
