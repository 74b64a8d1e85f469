import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { type ReactNode, useEffect, useMemo, useRef, useState, useSyncExternalStore } from "react";

import type { Recording } from "@/api/types";
import { OPACITY } from "@/components/attention/AttentionKey";
import { AttentionLayer } from "@/components/attention/AttentionLayer";
import { AttentionPanel } from "@/components/attention/AttentionPanel";
import { useAttention } from "@/components/attention/use-attention";
import { mapLabel } from "@/components/attention/words";
import { IconButton } from "@/components/controls/Button";
import { GameCanvas } from "@/components/game/GameCanvas";
import { playByKey } from "@/components/in-step/playback-keys";
import { RewardCurve, type ShownReward } from "@/components/reward/RewardCurve";
import { useGame } from "@/games/game";
import { classes } from "@/lib/classes";
import { seconds } from "@/lib/format";
import type { RecordedFrames } from "@/lib/game/codec";
import { Playback } from "@/lib/game/playback";
import type { ScreenPainter } from "@/lib/game/screen";
import { useFittingScreenSize } from "@/lib/game/use-screen-size";
import { stepOf } from "@/lib/recordings";

import styles from "./RecordingPlayer.module.css";
import { Scrubber } from "./Scrubber";
import { SpeedChoice } from "./SpeedChoice";

interface RecordingPlayerProps {
  frames: RecordedFrames;
  /** Marked over time; omitted where they say nothing of the behaviour. */
  hits?: Recording["hits"] | undefined;
  /** The learned reward to plot over time. */
  reward?: ShownReward | undefined;
  /** The frame to begin at, paused; without it the recording plays at once. */
  startFrame?: number | undefined;
  /** Height available for the screen, in CSS pixels. Must be a stable reference. */
  screenHeight: (windowHeight: number) => number;
  /** Rendered below the controls. */
  children?: (playback: Playback) => ReactNode;
}

/** Plays a recording back with a scrubber, speeds and single frames, by mouse and keyboard. */
export function RecordingPlayer(props: RecordingPlayerProps) {
  const game = useGame();
  const { frames, hits, reward, startFrame, screenHeight, children } = props;
  const playback = useMemo(() => new Playback(frames.last, frames.header.frame_rate_hz), [frames]);
  const stage = useRef<HTMLDivElement>(null);
  const size = useFittingScreenSize(stage, screenHeight, game);
  const [painter, setPainter] = useState<ScreenPainter | null>(null);
  const player = useRef<HTMLDivElement>(null);
  const attention = useAttention(reward, playback);
  const [opacity, setOpacity] = useState(OPACITY);
  const [keyed, setKeyed] = useState(false);

  // The keyboard controls the player, not the buttons before it.
  useEffect(() => player.current?.focus({ preventScroll: true }), []);

  useEffect(() => {
    if (!painter) return undefined;
    painter.setFormat(frames.header);
    const draw = () => painter.draw(frames.show(playback.snapshot().frame));
    const unsubscribe = playback.subscribe(draw);
    if (startFrame === undefined) playback.play();
    else playback.seek(startFrame);
    return () => {
      playback.pause();
      unsubscribe();
    };
  }, [frames, painter, playback, startFrame]);

  return (
    // Handles keys wherever the focus is inside; each has a control with the same effect.
    // eslint-disable-next-line jsx-a11y/no-noninteractive-element-interactions
    <div
      ref={player}
      className={classes(styles.player, keyed && styles.keyed)}
      role="group"
      aria-label={t({ message: "Player", context: "playback" })}
      tabIndex={-1}
      onKeyDown={(event) => {
        setKeyed(true);
        playByKey(event, playback, frames.last, game.frames_per_step);
      }}
    >
      <div className={styles.stage} ref={stage}>
        <GameCanvas size={size} label={t`Game screen`} onPainter={setPainter} />
        {attention.map && attention.step !== null && (
          <AttentionLayer
            map={attention.map.values}
            label={mapLabel(attention)}
            size={size}
            opacity={opacity}
          />
        )}
      </div>
      <Scrubber playback={playback} last={frames.last} hits={hits} />
      <Controls playback={playback} last={frames.last} />
      {reward && <RewardCurve reward={reward} playback={playback} last={frames.last} hits={hits} />}
      {reward && <AttentionPanel attention={attention} opacity={opacity} onOpacity={setOpacity} />}
      {children?.(playback)}
    </div>
  );
}

function Controls({ playback, last }: { playback: Playback; last: number }) {
  const game = useGame();
  const { frame, playing } = useSyncExternalStore(playback.subscribe, playback.snapshot);
  return (
    <>
      <div className={styles.controls}>
        <IconButton
          icon={playing ? "pause" : "play"}
          label={playing ? t`Pause` : t({ message: "Play", context: "playback" })}
          kind="secondary"
          onClick={() => playback.toggle()}
        />
        <IconButton icon="stepBack" label={t`One frame back`} onClick={() => playback.step(-1)} />
        <IconButton icon="stepOn" label={t`One frame forward`} onClick={() => playback.step(1)} />
        <SpeedChoice playback={playback} />
        <span className={styles.time}>
          <Trans>
            {seconds(frame / game.frame_rate_hz, 2)} of {seconds(last / game.frame_rate_hz, 2)} ·
            step {stepOf(frame, game)} · frame {frame}
          </Trans>
        </span>
      </div>
      <p className={styles.keys}>
        <span>
          <Trans>
            <kbd>Space</kbd> play or pause
          </Trans>
        </span>
        <span>
          <Trans>
            <kbd>←</kbd> <kbd>→</kbd> one frame
          </Trans>
        </span>
        <span>
          <Trans>
            with <kbd>Shift</kbd> one step
          </Trans>
        </span>
        <span>
          <Trans>
            <kbd>Home</kbd> <kbd>End</kbd> start and end
          </Trans>
        </span>
      </p>
    </>
  );
}
