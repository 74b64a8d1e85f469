import { useEffect, useRef } from "react";

import type { GameStream } from "@/features/play/stream/game-stream";
import { resolveColour } from "@/lib/browser/css-colour";
import type { ScreenSize } from "@/lib/game/use-screen-size";
import { playedBy, thingColour } from "@/lib/things";

import { type Marks, MarksPainter } from "./marks";
import styles from "./MarksCanvas.module.css";
import type { FrameSource } from "./use-screen";

interface MarksCanvasProps extends Marks {
  size: ScreenSize;
  stream: GameStream;
  frames: FrameSource;
}

/** Draws the marks over the game's screen, frame by frame and outside React. Decorative. */
export function MarksCanvas({ size, stream, frames, target, ghost }: MarksCanvasProps) {
  const ref = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const canvas = ref.current;
    const stage = canvas?.parentElement;
    if (!canvas || !stage) return undefined;
    const painter = new MarksPainter(
      canvas,
      { target, ghost },
      {
        target: resolveColour("var(--accent)", stage),
        ghost: resolveColour(thingColour(playedBy(ghost?.source ?? "person")), stage),
      },
    );
    return frames.watch((info) => {
      if (stream.aliens) painter.show(info, stream.snapshot().hits, stream.aliens);
    });
  }, [stream, frames, target, ghost]);
  return (
    <canvas
      ref={ref}
      className={styles.marks}
      aria-hidden="true"
      width={160}
      height={210}
      style={{ width: size.width, height: size.height }}
    />
  );
}
