import { pixelPath, SIGN } from "@/lib/pixels";

import styles from "./LostGame.module.css";

// prettier-ignore
const FOUR: readonly string[] = [
  "##..##",
  "##..##",
  "##..##",
  "######",
  "######",
  "....##",
  "....##",
  "....##",
];

/** 404 on a screen, with the sign of Tril as its zero. Decorative. */
export function LostGame() {
  return (
    <svg
      className={styles.screen}
      viewBox="0 0 40 24"
      shapeRendering="crispEdges"
      aria-hidden="true"
    >
      <path d={pixelPath(FOUR, 7, 7)} />
      <path className={styles.sign} d={pixelPath(SIGN, 16, 7)} />
      <path d={pixelPath(FOUR, 27, 7)} />
      <path className={styles.ground} d="M4 20h32v1h-32z" />
    </svg>
  );
}
