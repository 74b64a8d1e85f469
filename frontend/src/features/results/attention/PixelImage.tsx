import type { CSSProperties } from "react";

import styles from "@/components/game/GameCanvas.module.css";
import type { ScreenSize } from "@/lib/game/use-screen-size";

interface ImageProps {
  src: string;
  alt: string;
  size: ScreenSize;
}

/** A screenshot of the game at an integer scale, or as wide as there is room. */
export function ScreenImage({ src, alt, size }: ImageProps) {
  const style = { ...fitted(size), ...(size.reduced && { imageRendering: "auto" as const }) };
  return <img className={styles.canvas} src={src} alt={alt} style={style} loading="lazy" />;
}

/** A map of the screen, as large as the screenshot, so that each place is at the same place. */
export function MapImage({ src, alt, size }: ImageProps) {
  return <img className={styles.canvas} src={src} alt={alt} style={fitted(size)} loading="lazy" />;
}

function fitted({ width, height }: ScreenSize): CSSProperties {
  return { width: "100%", maxWidth: width, height: "auto", aspectRatio: width / height };
}
