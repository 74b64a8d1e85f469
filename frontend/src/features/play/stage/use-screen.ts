import { type RefObject, useCallback, useMemo, useRef } from "react";

import type { ClockHandle } from "@/features/play/hud/Clock";
import type { GameScreen, SeenFrame } from "@/features/play/stream/game-stream";
import type { Palette, ScreenPainter } from "@/lib/game/screen";

type Watcher = (seen: SeenFrame) => void;

/** Tells of the frames as they are shown, past React. */
export interface Frames {
  /** Calls back for the frame that is shown now and for each one after it; returns how to stop. */
  watch: (watcher: Watcher) => () => void;
}

/** The screen that frames are shown on: the canvas, the clock, and who else watches. */
export function useScreen(clock: RefObject<ClockHandle | null>) {
  const painter = useRef<ScreenPainter | null>(null);
  const palette = useRef<Palette | null>(null);
  const last = useRef<SeenFrame | null>(null);
  const watchers = useRef(new Set<Watcher>());
  const screen = useMemo<GameScreen>(
    () => ({
      setPalette: (colours) => {
        palette.current = colours;
        painter.current?.setPalette(colours);
      },
      show: (pixels, seen, maxFrames) => {
        painter.current?.draw(pixels);
        clock.current?.show(seen.frame, maxFrames);
        last.current = seen;
        for (const watcher of watchers.current) watcher(seen);
      },
    }),
    [clock],
  );
  const frames = useMemo<Frames>(
    () => ({
      watch: (watcher) => {
        watchers.current.add(watcher);
        if (last.current) watcher(last.current);
        return () => watchers.current.delete(watcher);
      },
    }),
    [],
  );
  const setPainter = useCallback((ready: ScreenPainter) => {
    painter.current = ready;
    if (palette.current) ready.setPalette(palette.current);
  }, []);
  return { screen, frames, setPainter };
}
