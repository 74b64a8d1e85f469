/** The sprites of the aliens, drawn for this page. */
import { pixelPath, SIGN } from "@/lib/pixels";

/** One sprite per row, bottom row first; 8x8 pixels. */
// prettier-ignore
const SPRITES: readonly (readonly string[])[] = [
  [
    "..#..#..",
    "...##...",
    ".######.",
    "##.##.##",
    "########",
    ".#.##.#.",
    "#......#",
    ".#....#.",
  ],
  [
    "..####..",
    ".######.",
    "#..##..#",
    "########",
    ".##..##.",
    "..#..#..",
    ".#.##.#.",
    "#......#",
  ],
  SIGN,
  [
    "#......#",
    ".#.##.#.",
    ".######.",
    "##.##.##",
    "########",
    ".######.",
    ".#....#.",
    "##....##",
  ],
  [
    "##....##",
    ".##..##.",
    "..####..",
    ".##..##.",
    "########",
    "#.####.#",
    "#.#..#.#",
    "...##...",
  ],
  [
    "#..##..#",
    "#..##..#",
    "##.##.##",
    ".######.",
    ".#.##.#.",
    ".######.",
    "..#..#..",
    ".##..##.",
  ],
];

/**
 * Returns the sprite of a row at (x, y) as an SVG path.
 *
 * @throws {RangeError} There is no such row.
 */
export function spritePath(row: number, x: number, y: number): string {
  const sprite = SPRITES[row];
  if (!sprite) throw new RangeError(`Expected a row from 0 to ${SPRITES.length - 1}, got ${row}.`);
  return pixelPath(sprite, x, y);
}
