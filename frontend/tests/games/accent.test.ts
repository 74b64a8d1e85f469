import { readFileSync } from "node:fs";

import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { accentOf, coloursIn, contrast, TEXT_CONTRAST } from "@/games/accent";

const tokens = readFileSync(new URL("../../src/styles/tokens.css", import.meta.url), "utf8");

/** Both colours of a token. */
function token(name: string) {
  const colours = coloursIn(new RegExp(`${name}: (.*);`).exec(tokens)?.[1] ?? "");
  if (!colours) throw new Error(`There is no token ${name}.`);
  return colours;
}

const BACKGROUNDS = ["--paper", "--surface", "--sunken"].map(token);
const backgrounds = {
  light: BACKGROUNDS.map(({ light }) => light),
  dark: BACKGROUNDS.map(({ dark }) => dark),
};

type Patch = readonly [number, number, number, number];

/** A picture of so many pixels of each colour. */
function picture(...patches: readonly Patch[]): Uint8ClampedArray {
  return Uint8ClampedArray.from(
    patches.flatMap(([n, ...rgb]) => Array.from({ length: n }, () => [...rgb, 255]).flat()),
  );
}

/** The colours of an accent's token, in both themes. */
function coloursOf(accent: ReturnType<typeof accentOf>, name: keyof NonNullable<typeof accent>) {
  const colours = coloursIn(accent?.[name] ?? "");
  if (!colours) throw new Error("There is no accent.");
  return colours;
}

describe("the accent of a game", () => {
  it("is readable on every background of both themes, whatever the picture", () => {
    const byte = fc.integer({ min: 0, max: 255 });
    fc.assert(
      fc.property(byte, byte, byte, (red, green, blue) => {
        const accent = accentOf(picture([10, red, green, blue]), backgrounds);
        fc.pre(accent !== null);
        for (const theme of ["light", "dark"] as const) {
          const under = [
            ...backgrounds[theme],
            coloursOf(accent, "--accent-wash")[theme],
            coloursOf(accent, "--on-accent")[theme],
          ];
          for (const name of ["--accent", "--accent-strong"] as const) {
            const colour = coloursOf(accent, name)[theme];
            for (const one of under)
              expect(contrast(colour, one)).toBeGreaterThanOrEqual(TEXT_CONTRAST);
          }
          const ink = token("--ink-2")[theme];
          const wash = coloursOf(accent, "--accent-wash")[theme];
          expect(contrast(ink, wash)).toBeGreaterThanOrEqual(TEXT_CONTRAST);
        }
      }),
      { numRuns: 500 },
    );
  });

  it("has the hue of what is large and colourful", () => {
    // Black, the blue of water, and a little yellow.
    const accent = accentOf(
      picture([900, 0, 0, 0], [300, 20, 60, 200], [9, 240, 220, 40]),
      backgrounds,
    );
    for (const theme of ["light", "dark"] as const) {
      const [red, green, blue] = coloursOf(accent, "--accent")[theme];
      expect(blue).toBeGreaterThan(Math.max(red, green));
    }
  });

  it("is not the red of errors", () => {
    const accent = accentOf(picture([900, 200, 30, 20], [50, 30, 160, 60]), backgrounds);
    const [red, green] = coloursOf(accent, "--accent").light;
    expect(green).toBeGreaterThan(red);
  });

  it.each([
    ["black and white", picture([90, 0, 0, 0], [10, 255, 255, 255])],
    ["nothing", picture()],
  ])("is left to the page where the picture has %s", (_, pixels) => {
    expect(accentOf(pixels, backgrounds)).toBeNull();
  });
});

describe("contrast", () => {
  it("is that of WCAG", () => {
    expect(contrast([0, 0, 0], [255, 255, 255])).toBeCloseTo(21);
    // The darkest grey that is too light on white is #777777 (WebAIM).
    expect(contrast([118, 118, 118], [255, 255, 255])).toBeGreaterThan(TEXT_CONTRAST);
    expect(contrast([119, 119, 119], [255, 255, 255])).toBeLessThan(TEXT_CONTRAST);
  });
});
