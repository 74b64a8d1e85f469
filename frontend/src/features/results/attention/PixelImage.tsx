import styles from "@/components/game/GameCanvas.module.css";
import type { ScreenSize } from "@/lib/game/use-screen-size";

interface ImageProps {
  src: string;
  alt: string;
  size: ScreenSize;
}

/** A screenshot of the game at an integer scale. */
export function ScreenImage({ src, alt, size: { reduced, ...size } }: ImageProps) {
  return (
    <img
      className={styles.canvas}
      src={src}
      alt={alt}
      style={{ ...size, ...(reduced && { imageRendering: "auto" }) }}
      loading="lazy"
    />
  );
}

/** A map of the screen, as large as the screenshot, so that each place is at the same place. */
export function MapImage({ src, alt, size: { width, height } }: ImageProps) {
  return (
    <img className={styles.canvas} src={src} alt={alt} style={{ width, height }} loading="lazy" />
  );
}
