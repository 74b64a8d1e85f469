import { pixelPath } from "@/lib/pixels";

// prettier-ignore
const LINES = [
  "...##...",
  "..####..",
  ".######.",
  "##.##.##",
  "########",
  "..#..#..",
  ".#.##.#.",
  "#.#..#.#",
];

/** The sign of Tril. */
export function Logo({ scale = 2 }: { scale?: number }) {
  const side = LINES.length;
  return (
    <svg
      viewBox={`0 0 ${side} ${side}`}
      width={side * scale}
      height={side * scale}
      fill="var(--accent)"
      shapeRendering="crispEdges"
      aria-hidden="true"
    >
      <path d={pixelPath(LINES, 0, 0)} />
    </svg>
  );
}
