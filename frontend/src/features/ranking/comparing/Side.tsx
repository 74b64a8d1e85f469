import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useEffect, useRef, useState } from "react";

import type { Behaviour, Recording } from "@/api/types";
import { Failed } from "@/components/feedback/States";
import { ItemGrid } from "@/components/game/ItemGrid";
import { GameCanvas } from "@/components/game/GameCanvas";
import { SourceBadge } from "@/components/recording/SourceBadge";
import { useGame } from "@/games/game";
import { describeCourse, describeResult } from "@/games/outcomes";
import type { RecordedFrames } from "@/lib/game/codec";
import { takenCells } from "@/lib/game/items";
import type { Playback } from "@/lib/game/playback";
import type { ScreenPainter } from "@/lib/game/screen";
import { type ScreenSize, useFittingScreenSize } from "@/lib/game/use-screen-size";
import { recordingName } from "@/lib/recordings";

import styles from "./Side.module.css";
import type { Screens } from "./use-playback-in-step";

interface SideProps {
  recording: Recording;
  behaviour: Behaviour;
  /** What it is in the comparison. */
  part: string;
  screens: Screens;
  playback: Playback | null;
  /** Height available for the screen, in CSS pixels. Must be a stable reference. */
  screenHeight: (windowHeight: number) => number;
}

/** One of two compared games: what it is, and its screen. */
export function Side({ recording, behaviour, part, screens, playback, screenHeight }: SideProps) {
  const game = useGame();
  const stage = useRef<HTMLDivElement>(null);
  const size = useFittingScreenSize(stage, screenHeight, game);
  const name = recordingName(recording);
  const result = describeResult(recording, behaviour, game);
  const { frames, error, retry } = screens;
  return (
    <section className={styles.side} aria-label={name}>
      <div className={styles.facts}>
        <ItemGrid hits={takenCells(recording)} target={behaviour.target} label="" />
        <div className={styles.words}>
          <div className={styles.title}>
            <h3>{name}</h3>
            <span className={styles.source}>
              <SourceBadge recording={recording} />
            </span>
            <span className={styles.part}>{part}</span>
          </div>
          {result && <p>{result}</p>}
          <p>{describeCourse(recording, game)}</p>
        </div>
      </div>
      <div className={styles.stage} ref={stage} style={{ minHeight: size.height }}>
        {error !== null && !frames ? (
          <div className={styles.failed}>
            <Failed what={name} error={error} onRetry={retry} />
          </div>
        ) : !frames ? (
          <p role="status">
            <Trans>Loading {name}…</Trans>
          </p>
        ) : (
          playback && (
            <Screen
              key={recording.id}
              frames={frames}
              playback={playback}
              size={size}
              label={t`Game screen of ${name}`}
            />
          )
        )}
      </div>
    </section>
  );
}

function Screen({
  frames,
  playback,
  size,
  label,
}: {
  frames: RecordedFrames;
  playback: Playback;
  size: ScreenSize;
  label: string;
}) {
  const [painter, setPainter] = useState<ScreenPainter | null>(null);
  useEffect(() => {
    if (!painter) return undefined;
    painter.setFormat(frames.header);
    const draw = () => painter.draw(frames.show(playback.snapshot().frame));
    draw();
    return playback.subscribe(draw);
  }, [frames, painter, playback]);
  return <GameCanvas size={size} label={label} onPainter={setPainter} />;
}
