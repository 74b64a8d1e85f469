import { t } from "@lingui/core/macro";
import { useEffect, useRef } from "react";

import type { ScreenSize } from "@/lib/game/use-screen-size";

import styles from "./Attention.module.css";
import { paintAttention } from "./colours";

/** Side of an observation in pixels; it covers the whole screen. */
const SIDE = 84;

/** An attention map over the game's picture, at the picture's scale. */
export function AttentionLayer({
  map,
  step,
  size,
  opacity,
}: {
  map: Float32Array;
  step: number;
  size: ScreenSize;
  opacity: number;
}) {
  const ref = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const context = ref.current?.getContext("2d");
    if (!context) return;
    const image = context.createImageData(SIDE, SIDE);
    paintAttention(map, image.data);
    context.putImageData(image, 0, 0);
  }, [map]);
  return (
    <canvas
      ref={ref}
      className={styles.layer}
      role="img"
      aria-label={t`What the reward looks at in step ${step}`}
      width={SIDE}
      height={SIDE}
      style={{ width: size.width, height: size.height, opacity }}
    />
  );
}
