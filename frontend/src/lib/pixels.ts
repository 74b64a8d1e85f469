/** Pictures made of pixels. */

/** Draws lines in which "#" is a pixel, at (x, y), as an SVG path of one rectangle per run. */
export function pixelPath(lines: readonly string[], x: number, y: number): string {
  let path = "";
  lines.forEach((line, dy) => {
    for (const run of line.matchAll(/#+/g)) {
      const length = run[0].length;
      path += `M${x + run.index} ${y + dy}h${length}v1h${-length}z`;
    }
  });
  return path;
}

/** The sign of Tril. */
// prettier-ignore
export const SIGN: readonly string[] = [
  "...##...",
  "..####..",
  ".######.",
  "##.##.##",
  "########",
  "..#..#..",
  ".#.##.#.",
  "#.#..#.#",
];
