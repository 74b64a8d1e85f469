/** The colours of attention maps: one-sided, from nothing to bright. */

/** Anchors of matplotlib's inferno, which the results page's pictures use, evenly spaced. */
const ANCHORS = [
  [0, 0, 4],
  [22, 11, 57],
  [66, 10, 104],
  [106, 23, 110],
  [147, 38, 103],
  [188, 55, 84],
  [221, 81, 58],
  [243, 120, 25],
  [252, 165, 10],
  [246, 215, 70],
  [252, 255, 164],
] as const;

export type Rgba = readonly [red: number, green: number, blue: number, alpha: number];

/**
 * Returns the colour of a share of the map's maximum, 0 to 1. Small shares are transparent, so that
 * the game's picture stays visible where the reward does not look.
 */
export function attentionColour(share: number): Rgba {
  const at = Math.min(Math.max(share, 0), 1) * (ANCHORS.length - 1);
  const below = ANCHORS[Math.floor(at)] ?? ANCHORS[0];
  const above = ANCHORS[Math.ceil(at)] ?? below;
  const mix = (channel: 0 | 1 | 2) =>
    Math.round(below[channel] + (above[channel] - below[channel]) * (at % 1));
  return [mix(0), mix(1), mix(2), Math.round(255 * Math.sqrt(Math.min(Math.max(share, 0), 1)))];
}

/** Writes a map's colours into RGBA bytes, four per value. */
export function paintAttention(map: Float32Array, into: Uint8ClampedArray): void {
  const most = map.reduce((high, value) => Math.max(high, value), 0);
  map.forEach((value, index) => into.set(attentionColour(most > 0 ? value / most : 0), index * 4));
}

/** A CSS gradient of the colours, from nothing on the left to most on the right. */
export function attentionGradient(): string {
  const stops = Array.from({ length: 21 }, (_, index) => {
    const [red, green, blue, alpha] = attentionColour(index / 20);
    return `rgb(${red} ${green} ${blue} / ${(alpha / 255).toFixed(3)})`;
  });
  return `linear-gradient(to right, ${stops.join(", ")})`;
}
