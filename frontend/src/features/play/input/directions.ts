/** The directions of a joystick, and the place of a thumb on a pad. */

export const DIRECTIONS = ["left", "right", "up", "down"] as const;
type Direction = (typeof DIRECTIONS)[number];

/** Within this share of the pad's radius a thumb rests. */
const DEAD_ZONE = 0.22;
/** Eight sectors of 45 degrees; a diagonal holds two directions. */
const SECTOR = Math.PI / 4;

const SECTORS: readonly (readonly Direction[])[] = [
  ["right"],
  ["right", "down"],
  ["down"],
  ["left", "down"],
  ["left"],
  ["left", "up"],
  ["up"],
  ["right", "up"],
];

/**
 * Returns the directions that a thumb holds.
 *
 * @param x From -1 at the left edge of the pad to 1 at its right edge.
 * @param y From -1 at its top to 1 at its bottom.
 */
export function directionsAt(x: number, y: number): readonly Direction[] {
  if (Math.hypot(x, y) < DEAD_ZONE) return [];
  const sector = Math.round(Math.atan2(y, x) / SECTOR);
  return SECTORS[(sector + SECTORS.length) % SECTORS.length] ?? [];
}
