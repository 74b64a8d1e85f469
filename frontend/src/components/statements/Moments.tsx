import { t } from "@lingui/core/macro";
import { useQuery } from "@tanstack/react-query";
import { useEffect, useMemo } from "react";

import { shownQuery } from "@/api/library";
import { framesQuery } from "@/api/recordings";
import type { Recording, ShownMoment } from "@/api/types";
import { ScreenInStep } from "@/components/in-step/ScreenInStep";
import { useGame } from "@/games/game";
import { useMedia } from "@/lib/browser/use-media";
import { seconds } from "@/lib/format";
import { Playback } from "@/lib/game/playback";
import { recordingName } from "@/lib/recordings";

import styles from "./Moments.module.css";

interface MomentsProps {
  behaviourId: number;
  /** Where the statement holds most. */
  shown: ShownMoment;
  /** Where it holds least. */
  contrast: ShownMoment;
}

/**
 * A few seconds in which a statement holds, beside a few in which it does not, in a loop. Where the
 * system asks for less motion, a picture of each.
 */
export function Moments({ behaviourId, shown, contrast }: MomentsProps) {
  const { frame_rate_hz: rateHz } = useGame();
  const calm = useMedia("(prefers-reduced-motion: reduce)");
  const nFrames = Math.max(shown.n_frames, contrast.n_frames);
  const playback = useMemo(() => new Playback(nFrames, rateHz, { loop: true }), [nFrames, rateHz]);
  useEffect(() => {
    if (calm) playback.seek(nFrames / 2);
    else playback.play();
    return () => playback.pause();
  }, [playback, calm, nFrames]);
  return (
    <div className={styles.moments}>
      <Moment behaviourId={behaviourId} moment={shown} title={t`Most of it`} playback={playback} />
      <Moment
        behaviourId={behaviourId}
        moment={contrast}
        title={t`Least of it`}
        playback={playback}
      />
    </div>
  );
}

interface MomentProps {
  behaviourId: number;
  moment: ShownMoment;
  title: string;
  playback: Playback;
}

function Moment({ behaviourId, moment, title, playback }: MomentProps) {
  const { frame_rate_hz: rateHz } = useGame();
  const { recording_id: id, first_frame: first, n_frames: nFrames } = moment;
  const recording = useQuery(shownQuery(behaviourId, id));
  const name = recordingName(recording.data);
  const [from, to] = [seconds(first / rateHz, 0), seconds((first + nFrames) / rateHz, 0)];
  return (
    <figure className={styles.moment}>
      {recording.data ? (
        <Screen recording={recording.data} moment={moment} playback={playback} />
      ) : (
        <ScreenInStep
          game={undefined}
          name={name}
          screens={{
            frames: undefined,
            error: recording.error,
            retry: () => void recording.refetch(),
          }}
          playback={null}
          screenHeight={screenHeight}
        />
      )}
      <figcaption>
        <strong>{title}</strong> {t`${name}, ${from} to ${to}`}
      </figcaption>
    </figure>
  );
}

function Screen({
  recording,
  moment,
  playback,
}: {
  recording: Recording;
  moment: ShownMoment;
  playback: Playback;
}) {
  const frames = useQuery(framesQuery(recording));
  return (
    <ScreenInStep
      game={recording}
      name={recordingName(recording)}
      screens={{ frames: frames.data, error: frames.error, retry: () => void frames.refetch() }}
      playback={playback}
      firstFrame={moment.first_frame}
      screenHeight={screenHeight}
    />
  );
}

const HEIGHT_PX = 210;
const screenHeight = () => HEIGHT_PX;
