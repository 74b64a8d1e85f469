import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useEffect, useRef, useState } from "react";

import { Failed } from "@/components/feedback/States";
import { GameCanvas } from "@/components/game/GameCanvas";
import { useGame } from "@/games/game";
import type { RecordedFrames } from "@/lib/game/codec";
import type { Playback } from "@/lib/game/playback";
import type { ScreenPainter } from "@/lib/game/screen";
import { type ScreenSize, useFittingScreenSize } from "@/lib/game/use-screen-size";

import styles from "./ScreenInStep.module.css";
import type { Played, Screens } from "./use-playback-in-step";

interface ScreenInStepProps {
  /** Undefined until it is known. */
  game: Played | undefined;
  /** What the game is called, in its label and where it is missing. */
  name: string;
  /** Undefined until it is known which. */
  screens: Screens | undefined;
  playback: Playback | null;
  /** The recording's frame that is shown with the playback's first one. */
  firstFrame?: number | undefined;
  /** Height available for the screen, in CSS pixels. Must be a stable reference. */
  screenHeight: (windowHeight: number) => number;
}

/** The screen of a recording that plays in step with others, or why it is missing. */
export function ScreenInStep(props: ScreenInStepProps) {
  const { game: played, name, screens, playback, firstFrame = 0, screenHeight } = props;
  const game = useGame();
  const stage = useRef<HTMLDivElement>(null);
  const size = useFittingScreenSize(stage, screenHeight, game);
  return (
    <div className={styles.stage} ref={stage} style={{ minHeight: size.height }}>
      {screens && screens.error !== null && !screens.frames ? (
        <div className={styles.failed}>
          <Failed what={name} error={screens.error} onRetry={screens.retry} />
        </div>
      ) : !screens?.frames ? (
        <p role="status">
          <Trans>Loading {name}…</Trans>
        </p>
      ) : (
        playback && (
          <Screen
            key={played?.frames_url}
            frames={screens.frames}
            playback={playback}
            firstFrame={firstFrame}
            size={size}
            label={t`Game screen of ${name}`}
          />
        )
      )}
    </div>
  );
}

function Screen({
  frames,
  playback,
  firstFrame,
  size,
  label,
}: {
  frames: RecordedFrames;
  playback: Playback;
  firstFrame: number;
  size: ScreenSize;
  label: string;
}) {
  const [painter, setPainter] = useState<ScreenPainter | null>(null);
  useEffect(() => {
    if (!painter) return undefined;
    painter.setFormat(frames.header);
    const draw = () => painter.draw(frames.show(firstFrame + playback.snapshot().frame));
    draw();
    return playback.subscribe(draw);
  }, [frames, painter, playback, firstFrame]);
  return <GameCanvas size={size} label={label} onPainter={setPainter} />;
}
