/** The accent colour of a game's pages, from the game's picture. */

type Rgb = readonly [red: number, green: number, blue: number];

/** The colour of each theme. */
export interface Themed<T> {
  readonly light: T;
  readonly dark: T;
}

/** Values of the tokens that make up the accent, as CSS. */
export type Accent = Readonly<
  Record<"--accent" | "--accent-strong" | "--on-accent" | "--accent-wash", string>
>;

/** Least contrast of text: success criterion 1.4.3 of WCAG 2.2. */
export const TEXT_CONTRAST = 4.5;

/** Colours that are paler have no hue to speak of. */
const LEAST_CHROMA = 0.05;
/** The accent's own bounds: told from grey, and not gaudy. */
const [PALEST, MOST_VIVID] = [0.11, 0.16];
/** Hues of errors, in degrees, which an accent must not be taken for. */
const ERRORS = { from: 8, to: 42 } as const;
const LIGHTNESS_STEP = 0.005;

/**
 * Returns the accent for a picture: the hue of its most saturated frequent colour, as light or dark
 * as text needs on each theme's backgrounds; null if the picture has no such colour.
 *
 * @param pixels RGBA, as a canvas gives them.
 * @param backgrounds What the accent stands on.
 */
export function accentOf(
  pixels: Uint8ClampedArray,
  backgrounds: Themed<readonly Rgb[]>,
): Accent | null {
  const main = mainColour(pixels);
  if (!main) return null;
  const hue = main.hue;
  const chroma = Math.min(Math.max(main.chroma, PALEST), MOST_VIVID);
  const wash = { light: rgbOf(0.95, 0.035, hue), dark: rgbOf(0.28, 0.035, hue) };
  const on = { light: [255, 255, 255] as Rgb, dark: rgbOf(0.18, 0.03, hue) };
  const shade = (theme: keyof Themed<Rgb>, start: number, step: number) =>
    readable(start, step, chroma, hue, [...backgrounds[theme], wash[theme], on[theme]]);
  const [light, dark] = [shade("light", 0.6, -LIGHTNESS_STEP), shade("dark", 0.7, LIGHTNESS_STEP)];
  return {
    "--accent": themed(rgbOf(light, chroma, hue), rgbOf(dark, chroma, hue)),
    "--accent-strong": themed(rgbOf(light - 0.07, chroma, hue), rgbOf(dark + 0.05, chroma, hue)),
    "--on-accent": themed(on.light, on.dark),
    "--accent-wash": themed(wash.light, wash.dark),
  };
}

/** Returns the colours of both themes in a token's value, "light-dark(#fff, #131312)". */
export function coloursIn(token: string): Themed<Rgb> | null {
  const [light, dark] = [...token.matchAll(/#([0-9a-f]{6}|[0-9a-f]{3})\b/gi)].map(([, digits]) =>
    fromHex(digits ?? ""),
  );
  return light && dark ? { light, dark } : null;
}

/** Returns the contrast of two colours, from 1 to 21, as WCAG defines it. */
export function contrast(a: Rgb, b: Rgb): number {
  const [lighter, darker] = [luminance(a), luminance(b)].sort((one, other) => other - one);
  return ((lighter ?? 0) + 0.05) / ((darker ?? 0) + 0.05);
}

/** Returns chroma and hue of the colour that is both frequent and saturated. */
function mainColour(pixels: Uint8ClampedArray): { chroma: number; hue: number } | null {
  const counts = new Map<number, number>();
  for (let at = 0; at + 3 < pixels.length; at += 4) {
    const [red, green, blue] = [pixels[at] ?? 0, pixels[at + 1] ?? 0, pixels[at + 2] ?? 0];
    const colour = ((red & 0xf8) << 16) | ((green & 0xf8) << 8) | (blue & 0xf8);
    counts.set(colour, (counts.get(colour) ?? 0) + 1);
  }
  let best: { chroma: number; hue: number; weight: number } | null = null;
  for (const [colour, count] of counts) {
    const { chroma, hue } = lchOf([(colour >> 16) & 255, (colour >> 8) & 255, colour & 255]);
    const weight = chroma * Math.sqrt(count);
    if (chroma < LEAST_CHROMA || (hue > ERRORS.from && hue < ERRORS.to)) continue;
    if (!best || weight > best.weight) best = { chroma, hue, weight };
  }
  return best;
}

/** Returns the first lightness from a start on that can be read on all backgrounds. */
function readable(
  start: number,
  step: number,
  chroma: number,
  hue: number,
  backgrounds: readonly Rgb[],
): number {
  let lightness = start;
  while (lightness > 0 && lightness < 1) {
    const colour = rgbOf(lightness, chroma, hue);
    if (backgrounds.every((one) => contrast(colour, one) >= TEXT_CONTRAST)) break;
    lightness += step;
  }
  return lightness;
}

function themed(light: Rgb, dark: Rgb): string {
  return `light-dark(${toHex(light)}, ${toHex(dark)})`;
}

function fromHex(digits: string): Rgb {
  const six = digits.length === 3 ? digits.replace(/./g, "$&$&") : digits;
  const value = Number.parseInt(six, 16);
  return [value >> 16, (value >> 8) & 255, value & 255];
}

function toHex(colour: Rgb): string {
  return `#${colour.map((value) => value.toString(16).padStart(2, "0")).join("")}`;
}

/** From sRGB to linear light. */
function linear(value: number): number {
  const share = value / 255;
  return share <= 0.04045 ? share / 12.92 : ((share + 0.055) / 1.055) ** 2.4;
}

function luminance([red, green, blue]: Rgb): number {
  return 0.2126 * linear(red) + 0.7152 * linear(green) + 0.0722 * linear(blue);
}

/** Returns a colour's chroma and hue in OKLCH (Ottosson, "A perceptual color space", 2020). */
function lchOf(colour: Rgb): { chroma: number; hue: number } {
  const [red, green, blue] = colour.map(linear) as [number, number, number];
  const l = Math.cbrt(0.4122214708 * red + 0.5363325363 * green + 0.0514459929 * blue);
  const m = Math.cbrt(0.2119034982 * red + 0.6806995451 * green + 0.1073969566 * blue);
  const s = Math.cbrt(0.0883024619 * red + 0.2817188376 * green + 0.6299787005 * blue);
  const a = 1.9779984951 * l - 2.428592205 * m + 0.4505937099 * s;
  const b = 0.0259040371 * l + 0.7827717662 * m - 0.808675766 * s;
  return { chroma: Math.hypot(a, b), hue: ((Math.atan2(b, a) * 180) / Math.PI + 360) % 360 };
}

/** Returns a colour of OKLCH in sRGB; what sRGB can't show is made paler. */
function rgbOf(lightness: number, chroma: number, hue: number): Rgb {
  const radians = (hue * Math.PI) / 180;
  const [a, b] = [chroma * Math.cos(radians), chroma * Math.sin(radians)];
  const l = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const m = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const s = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  const channels = [
    4.0767416621 * l - 3.3077115913 * m + 0.2309699292 * s,
    -1.2684380046 * l + 2.6097574011 * m - 0.3413193965 * s,
    -0.0041960863 * l - 0.7034186147 * m + 1.707614701 * s,
  ];
  const isShown = channels.every((share) => share >= -1e-4 && share <= 1 + 1e-4);
  if (!isShown && chroma > 0) return rgbOf(lightness, Math.max(chroma - 0.005, 0), hue);
  return channels.map((share) => {
    const clipped = Math.min(Math.max(share, 0), 1);
    const value = clipped <= 0.0031308 ? clipped * 12.92 : 1.055 * clipped ** (1 / 2.4) - 0.055;
    return Math.round(value * 255);
  }) as unknown as Rgb;
}
