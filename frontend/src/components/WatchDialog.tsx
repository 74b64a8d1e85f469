import { useQuery } from "@tanstack/react-query";
import {
  type KeyboardEvent,
  type ReactNode,
  useEffect,
  useMemo,
  useRef,
  useState,
  useSyncExternalStore,
} from "react";

import { IconButton } from "./Button";
import { Dialog } from "./Dialog";
import { GameCanvas } from "./GameCanvas";
import { Scrubber } from "./Scrubber";
import { Failed, Loading, Notice } from "./States";
import styles from "./WatchDialog.module.css";

import { messageOf } from "@/api/client";
import { framesQuery } from "@/api/recordings";
import { rewardTraceQuery } from "@/api/runs";
import type { Recording } from "@/api/types";
import type { RecordedFrames } from "@/lib/codec";
import { FRAME_RATE_HZ, FRAMES_PER_STEP, seconds } from "@/lib/format";
import { Playback, SPEEDS } from "@/lib/playback";
import { courseInWords, recordingName, scoreInWords, stepOf } from "@/lib/recordings";
import type { ScreenPainter } from "@/lib/screen";
import { useFittingScreenSize } from "@/lib/use-screen-size";

interface WatchDialogProps {
  recording: Recording;
  /** Target aliens of the behaviour, if it has a target. */
  nTargets: number | null;
  title?: ReactNode;
  /** Shows this run's R along time. */
  runId?: string | undefined;
  /** Where to begin, standing still. */
  startFrame?: number | undefined;
  onClose: () => void;
}

/** Watches a recording: play, pause, any frame, any speed. */
export function WatchDialog(props: WatchDialogProps) {
  const { recording, nTargets, title, runId, startFrame, onClose } = props;
  const frames = useQuery(framesQuery(recording));
  const trace = useQuery({
    ...rewardTraceQuery(runId ?? "", recording.id),
    enabled: runId !== undefined,
  });
  return (
    <Dialog title={title ?? recordingName(recording)} onClose={onClose} width="56rem">
      <div className={styles.watch}>
        {frames.data ? (
          <Player
            frames={frames.data}
            hits={recording.hits}
            rewards={trace.data?.rewards}
            startFrame={startFrame}
          />
        ) : frames.error ? (
          <Failed
            what="The recording"
            error={frames.error}
            onRetry={() => void frames.refetch()}
          />
        ) : (
          <Loading what="the recording" rows={1} height="20rem" />
        )}
        {trace.error && (
          <Notice tone="calm" live>
            <p>R along time can&rsquo;t be shown: {messageOf(trace.error)}</p>
          </Notice>
        )}
        <p className={styles.facts}>
          <span>{scoreInWords(recording, nTargets)}</span>
          <span>{courseInWords(recording)}</span>
        </p>
      </div>
    </Dialog>
  );
}

/** The dialog's chrome takes this much of the window's height, with R and without. */
const CHROME_PX = 300;
const screenHeight = (windowHeight: number) => windowHeight - CHROME_PX;

function Player({
  frames,
  hits,
  rewards,
  startFrame,
}: {
  frames: RecordedFrames;
  hits: Recording["hits"];
  rewards: readonly number[] | undefined;
  startFrame: number | undefined;
}) {
  const playback = useMemo(
    () => new Playback(frames.last, frames.header.frame_rate_hz),
    [frames],
  );
  const stage = useRef<HTMLDivElement>(null);
  const size = useFittingScreenSize(stage, screenHeight);
  const [painter, setPainter] = useState<ScreenPainter | null>(null);
  const player = useRef<HTMLDivElement>(null);

  // The dialog's first button is Close; the keys are meant for the player.
  useEffect(() => player.current?.focus(), []);

  useEffect(() => {
    if (!painter) return undefined;
    painter.setPalette(frames.header.palette);
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
    // Keys reach the player from wherever in it the focus is; each has a control beside it.
    // eslint-disable-next-line jsx-a11y/no-noninteractive-element-interactions
    <div
      ref={player}
      className={styles.watch}
      role="group"
      aria-label="Player"
      tabIndex={-1}
      onKeyDown={(event) => onKey(event, playback, frames.last)}
    >
      <div className={styles.stage} ref={stage}>
        <GameCanvas size={size} label="Game screen" onPainter={setPainter} />
      </div>
      <Scrubber playback={playback} last={frames.last} hits={hits} rewards={rewards} />
      <Controls playback={playback} last={frames.last} />
    </div>
  );
}

function Controls({ playback, last }: { playback: Playback; last: number }) {
  const { frame, playing, speed } = useSyncExternalStore(playback.subscribe, playback.snapshot);
  return (
    <>
      <div className={styles.controls}>
        <IconButton
          icon={playing ? "pause" : "play"}
          label={playing ? "Pause" : "Play"}
          kind="secondary"
          onClick={() => playback.toggle()}
        />
        <IconButton icon="stepBack" label="One frame back" onClick={() => playback.step(-1)} />
        <IconButton icon="stepOn" label="One frame on" onClick={() => playback.step(1)} />
        <label>
          <span className="visually-hidden">Speed</span>
          <select
            className={styles.speed}
            value={speed}
            onChange={(event) => playback.setSpeed(Number(event.currentTarget.value))}
          >
            {SPEEDS.map((one) => (
              <option key={one} value={one}>
                {one}×
              </option>
            ))}
          </select>
        </label>
        <span className={styles.time}>
          {seconds(frame / FRAME_RATE_HZ, 2)} of {seconds(last / FRAME_RATE_HZ, 2)} · step{" "}
          {stepOf(frame)} · frame {frame}
        </span>
      </div>
      <p className={styles.keys}>
        <span>
          <kbd>Space</kbd> play or pause
        </span>
        <span>
          <kbd>←</kbd> <kbd>→</kbd> one frame
        </span>
        <span>
          <kbd>Shift</kbd> with them one step
        </span>
      </p>
    </>
  );
}

function onKey(event: KeyboardEvent, playback: Playback, last: number): void {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const target = event.target as HTMLElement;
  if (target.tagName === "SELECT") return;
  const leap = event.shiftKey ? FRAMES_PER_STEP : 1;
  const actions: Readonly<Record<string, () => void>> = {
    ArrowLeft: () => playback.step(-leap),
    ArrowRight: () => playback.step(leap),
    Home: () => playback.seek(0),
    End: () => playback.seek(last),
    Space: () => playback.toggle(),
  };
  const action = actions[event.code];
  // Space on a button presses the button.
  if (!action || (event.code === "Space" && target.tagName === "BUTTON")) return;
  event.preventDefault();
  action();
}
