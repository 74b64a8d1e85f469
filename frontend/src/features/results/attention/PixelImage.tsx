import styles from "@/components/game/GameCanvas.module.css";
import { useGame } from "@/games/game";
import { useScreenSize } from "@/lib/game/use-screen-size";

/** A screenshot of the game at an integer scale, fitted into a box of CSS pixels. */
export function ScreenImage({
  src,
  alt,
  width,
  height,
}: {
  src: string;
  alt: string;
  width: number;
  height: number;
}) {
  const { reduced, ...size } = useScreenSize(width, height, useGame());
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

/** A square image, each of its pixels drawn as `scale` by `scale`. */
export function SquareImage({
  src,
  alt,
  pixels,
  scale,
}: {
  src: string;
  alt: string;
  pixels: number;
  scale: number;
}) {
  const side = pixels * scale;
  return (
    <img className={styles.canvas} src={src} alt={alt} width={side} height={side} loading="lazy" />
  );
}
