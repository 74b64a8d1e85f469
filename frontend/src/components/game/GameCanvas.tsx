import { type ComponentProps, useEffect, useRef } from "react";

import { ScreenPainter } from "@/lib/game/screen";
import type { ScreenSize } from "@/lib/game/use-screen-size";

import styles from "./GameCanvas.module.css";

interface GameCanvasProps extends ComponentProps<"canvas"> {
  size: ScreenSize;
  label: string;
  /** Gets what draws on the canvas, once it is there. Must keep its identity. */
  onPainter: (painter: ScreenPainter) => void;
}

/** The game's screen. Frames are painted on it directly, never through React's state. */
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
      width={160}
      height={210}
      style={{ width: size.width, height: size.height }}
      {...rest}
    />
  );
}
