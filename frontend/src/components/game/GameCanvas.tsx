import { type ComponentProps, useEffect, useRef } from "react";

import { ScreenPainter } from "@/lib/game/screen";
import type { ScreenSize } from "@/lib/game/use-screen-size";

import styles from "./GameCanvas.module.css";

interface GameCanvasProps extends ComponentProps<"canvas"> {
  size: ScreenSize;
  label: string;
  /** Receives the painter once the canvas is mounted. Must be a stable reference. */
  onPainter: (painter: ScreenPainter) => void;
}

/** The game's screen. Frames are painted on it directly, never through React state. */
export function GameCanvas({ size, label, onPainter, ...rest }: GameCanvasProps) {
  const ref = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    if (ref.current) onPainter(new ScreenPainter(ref.current));
  }, [onPainter]);
  return (
    <canvas
      ref={ref}
      className={styles.canvas}
      role="img"
      aria-label={label}
      style={{
        width: size.width,
        height: size.height,
        ...(size.reduced && { imageRendering: "auto" }),
      }}
      {...rest}
    />
  );
}
