import { t } from "@lingui/core/macro";
import { useQuery } from "@tanstack/react-query";
import { useEffect, useMemo, useRef, useState, useSyncExternalStore } from "react";

import { shownQuery } from "@/api/library";
import { framesQuery } from "@/api/recordings";
import type { NamedThing, Recording, ThingInSight } from "@/api/types";
import { IconButton } from "@/components/controls/Button";
import { Failed, Loading } from "@/components/feedback/States";
import { GameCanvas } from "@/components/game/GameCanvas";
import { Scrubber } from "@/components/recording/Scrubber";
import { useGame } from "@/games/game";
import { classes } from "@/lib/classes";
import type { RecordedFrames } from "@/lib/game/codec";
import { Playback } from "@/lib/game/playback";
import type { ScreenPainter } from "@/lib/game/screen";
import { useFittingScreenSize } from "@/lib/game/use-screen-size";
import { useSettled } from "@/lib/use-settled";

import styles from "./Sight.module.css";
import { inSightQuery } from "./things";

interface PointingProps {
  behaviourId: number;
  things: readonly NamedThing[];
  /** The kind that is marked. */
  marked: number | null;
  /** Called with the kind pointed at, null when there is none. */
  onPoint: (kind: number | null) => void;
  onChoose: (kind: number) => void;
}

/** A paused game in which a person points at a thing, at any moment. */
export function Sight({ recordingId, ...pointing }: PointingProps & { recordingId: number }) {
  const recording = useQuery(shownQuery(pointing.behaviourId, recordingId));
  if (recording.data) return <Paused recording={recording.data} {...pointing} />;
  if (recording.error)
    return (
      <Failed
        what={t`The recording`}
        error={recording.error}
        onRetry={() => void recording.refetch()}
      />
    );
  return <Loading what={t`the recording`} rows={1} height="15rem" />;
}

function Paused({ recording, ...pointing }: PointingProps & { recording: Recording }) {
  const frames = useQuery(framesQuery(recording));
  if (frames.data) return <Moment recordingId={recording.id} frames={frames.data} {...pointing} />;
  if (frames.error)
    return (
      <Failed what={t`The recording`} error={frames.error} onRetry={() => void frames.refetch()} />
    );
  return <Loading what={t`the recording`} rows={1} height="15rem" />;
}

/** How long a moment has to stay before its things are asked for. */
const SETTLED_MS = 120;
/** The part of the window's height that the rest of the dialog needs. */
const CHROME_PX = 340;
const screenHeight = (windowHeight: number) => Math.max(windowHeight - CHROME_PX, 210);

interface MomentProps extends PointingProps {
  recordingId: number;
  frames: RecordedFrames;
}

function Moment({ behaviourId, recordingId, frames, ...pointing }: MomentProps) {
  const game = useGame();
  const { frames_per_step: perStep, frame_rate_hz: rateHz } = game;
  const playback = useMemo(() => {
    const paused = new Playback(frames.last, rateHz);
    // Most things are there by then.
    paused.seek(frames.last / 3);
    return paused;
  }, [frames, rateHz]);
  const { frame } = useSyncExternalStore(playback.subscribe, playback.snapshot);
  // What is known is known of whole steps.
  const lastStep = Math.floor(frames.last / perStep);
  const step = Math.max(1, Math.min(Math.ceil(frame / perStep), lastStep));
  const settled = useSettled(step, SETTLED_MS);
  const { data: inSight } = useQuery(inSightQuery(behaviourId, recordingId, settled - 1));
  const stage = useRef<HTMLDivElement>(null);
  const size = useFittingScreenSize(stage, screenHeight, game);
  const [painter, setPainter] = useState<ScreenPainter | null>(null);
  useEffect(() => {
    if (!painter) return;
    painter.setFormat(frames.header);
    painter.draw(frames.show(step * perStep));
  }, [painter, frames, step, perStep, size]);
  return (
    <div className={styles.sight}>
      <div className={styles.stage} ref={stage}>
        <div className={styles.screen} style={{ width: size.width, height: size.height }}>
          <GameCanvas size={size} label={t`Game screen`} onPainter={setPainter} />
          {inSight && settled === step && <Boxes inSight={inSight} {...pointing} />}
        </div>
      </div>
      <div className={styles.transport}>
        <IconButton
          icon="stepBack"
          label={t`One step back`}
          onClick={() => playback.step(-perStep)}
        />
        <IconButton
          icon="stepOn"
          label={t`One step forward`}
          onClick={() => playback.step(perStep)}
        />
        <div className={styles.position}>
          <Scrubber playback={playback} last={frames.last} />
        </div>
      </div>
    </div>
  );
}

interface BoxesProps extends Omit<PointingProps, "behaviourId"> {
  inSight: readonly ThingInSight[];
}

/** What is pointed at on the picture. The list of things does the same for the keyboard. */
function Boxes({ inSight, things, marked, onPoint, onChoose }: BoxesProps) {
  const { width, height } = useGame();
  const names = new Map(things.map(({ kind, name }) => [kind, name]));
  return (
    <div aria-hidden="true">
      {inSight.map((thing) => (
        <button
          key={`${thing.kind} ${thing.left} ${thing.top}`}
          type="button"
          tabIndex={-1}
          title={names.get(thing.kind)}
          data-kind={thing.kind}
          className={classes(styles.box, thing.kind === marked && styles.marked)}
          style={{
            left: `${(thing.left / width) * 100}%`,
            top: `${(thing.top / height) * 100}%`,
            width: `${(thing.width / width) * 100}%`,
            height: `${(thing.height / height) * 100}%`,
          }}
          onMouseEnter={() => onPoint(thing.kind)}
          onMouseLeave={() => onPoint(null)}
          onClick={() => onChoose(thing.kind)}
        />
      ))}
    </div>
  );
}
