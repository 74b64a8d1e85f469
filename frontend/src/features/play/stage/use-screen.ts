import { type RefObject, useCallback, useMemo, useRef } from "react";

import type { ClockHandle } from "@/features/play/hud/Clock";
import type { GameScreen } from "@/features/play/stream/game-stream";
import type { FrameInfo } from "@/games/view";
import type { ScreenFormat, ScreenPainter } from "@/lib/game/screen";

type Watcher = (info: FrameInfo) => void;

/** Notifies of frames as they are shown, outside React. */
export interface FrameSource {
  /** Calls back for the current frame and each later one; returns a function that stops. */
  watch: (watcher: Watcher) => () => void;
}

/** Shows frames on the canvas and the clock, and notifies watchers. */
export function useScreen(clock: RefObject<ClockHandle | null>) {
  const painter = useRef<ScreenPainter | null>(null);
  const format = useRef<ScreenFormat | null>(null);
  const last = useRef<FrameInfo | null>(null);
  const watchers = useRef(new Set<Watcher>());
  const screen = useMemo<GameScreen>(
    () => ({
      setFormat: (sent) => {
        format.current = sent;
        painter.current?.setFormat(sent);
      },
      show: (pixels, info, maxFrames) => {
        painter.current?.draw(pixels);
        clock.current?.show(info.frame, maxFrames);
        last.current = info;
        for (const watcher of watchers.current) watcher(info);
      },
    }),
    [clock],
  );
  const frames = useMemo<FrameSource>(
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
    if (format.current) ready.setFormat(format.current);
  }, []);
  return { screen, frames, setPainter };
}
