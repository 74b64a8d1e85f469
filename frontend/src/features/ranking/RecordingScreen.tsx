import { t } from "@lingui/core/macro";
import { useQuery } from "@tanstack/react-query";
import { useEffect, useRef, useState } from "react";

import { framesQuery } from "@/api/recordings";
import type { Recording } from "@/api/types";
import { GameCanvas } from "@/components/game/GameCanvas";
import { GamePicture } from "@/components/recording/GamePicture";
import { useGame } from "@/games/game";
import type { RecordedFrames } from "@/lib/game/codec";
import { Playback } from "@/lib/game/playback";
import type { ScreenPainter } from "@/lib/game/screen";
import { type ScreenSize, useScreenSize } from "@/lib/game/use-screen-size";

import styles from "./RecordingScreen.module.css";

interface RecordingScreenProps {
  recording: Recording;
  /** Whether it plays in a loop; otherwise a moment of it is shown. */
  playing: boolean;
  /** Available size in CSS pixels. */
  width: number;
  height: number;
}

/** A moment of a recording, or the recording playing in a loop. */
export function RecordingScreen({ recording, playing, width, height }: RecordingScreenProps) {
  const size = useScreenSize(width, height, useGame());
  const { data: frames } = useQuery({ ...framesQuery(recording), enabled: playing });
  return (
    <div className={styles.screen} style={{ width, height }}>
      <GamePicture recording={recording} box={{ width, height }} />
      {playing && frames && (
        <div className={styles.stacked}>
          <Loop frames={frames} size={size} />
        </div>
      )}
    </div>
  );
}

function Loop({ frames, size }: { frames: RecordedFrames; size: ScreenSize }) {
  const [painter, setPainter] = useState<ScreenPainter | null>(null);
  useEffect(() => {
    if (!painter) return undefined;
    const { header } = frames;
    const playback = new Playback(frames.last, header.frame_rate_hz, { loop: true });
    painter.setFormat(header);
    playback.subscribe(() => painter.draw(frames.show(playback.snapshot().frame)));
    playback.play();
    return () => playback.dispose();
  }, [frames, painter]);
  return <GameCanvas size={size} label={t`Recording, playing`} onPainter={setPainter} />;
}

/** Long enough that a pointer passing over starts nothing. */
const HOVER_DELAY_MS = 150;

/** Returns handlers to spread on an element, for when it begins to be hovered or focused. */
export function useHover(onStart: () => void) {
  const timer = useRef<ReturnType<typeof setTimeout> | null>(null);
  const stop = () => {
    if (timer.current) clearTimeout(timer.current);
  };
  const start = () => {
    stop();
    timer.current = setTimeout(onStart, HOVER_DELAY_MS);
  };
  useEffect(() => stop, []);
  return { onMouseEnter: start, onMouseLeave: stop, onFocus: start, onBlur: stop };
}
