import { useEffect, useRef } from "react";

import type { GameStream } from "@/features/play/stream/game-stream";
import { viewOf } from "@/games/views";
import { useGame } from "@/games/game";
import type { Marks, MarksPainter, Overlay } from "@/games/view";
import { resolveColour } from "@/lib/browser/css-colour";
import type { ScreenSize } from "@/lib/game/use-screen-size";
import { playedBy, actorColour } from "@/lib/actors";

import styles from "./MarksCanvas.module.css";
import type { FrameSource } from "./use-screen";

interface MarksCanvasProps extends Marks {
  size: ScreenSize;
  stream: GameStream;
  frames: FrameSource;
}

/** Draws the marks over the game's screen, frame by frame and outside React. Decorative. */
export function MarksCanvas({ size, stream, frames, target, ghost }: MarksCanvasProps) {
  const { name, width, height } = useGame();
  const ref = useRef<HTMLCanvasElement>(null);
  useEffect(() => {
    const canvas = ref.current;
    const stage = canvas?.parentElement;
    if (!canvas || !stage) return undefined;
    const colours = {
      target: resolveColour("var(--accent)", stage),
      ghost: resolveColour(actorColour(playedBy(ghost?.source ?? "person")), stage),
    };
    const make = (overlay: Overlay | null) =>
      overlay && viewOf(name)?.marksPainter(canvas, { target, ghost }, colours, overlay);
    let painter: MarksPainter | null | undefined = null;
    return frames.watch((info) => {
      painter ??= make(stream.overlay);
      painter?.show(info, stream.snapshot().hits);
    });
  }, [name, stream, frames, target, ghost]);
  return (
    <canvas
      ref={ref}
      className={styles.marks}
      aria-hidden="true"
      width={width}
      height={height}
      style={{ width: size.width, height: size.height }}
    />
  );
}
