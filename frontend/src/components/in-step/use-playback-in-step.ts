import { useQueries, type UseQueryResult } from "@tanstack/react-query";
import { useEffect, useMemo, useState } from "react";

import { framesQuery } from "@/api/recordings";
import type { Recording } from "@/api/types";
import { useGame } from "@/games/game";
import { useMedia } from "@/lib/browser/use-media";
import type { RecordedFrames } from "@/lib/game/codec";
import { Playback } from "@/lib/game/playback";

/** What is played: anything that has frames. */
export type Played = Pick<Recording, "frames_url">;

/** The screens of a recording, or why they are missing. */
export interface Screens {
  readonly frames: RecordedFrames | undefined;
  readonly error: unknown;
  readonly retry: () => void;
}

interface PlaybackInStep {
  /** Of all recordings; the shorter ones stop at their end. Null until all can be played. */
  readonly playback: Playback | null;
  /** The last frame of the longest one. */
  readonly last: number;
  readonly screens: readonly Screens[];
  readonly setSpeed: (speed: number) => void;
}

/**
 * Plays recordings in step from their beginning, as soon as all are there. Where the system asks
 * for less motion, it shows how they end and waits.
 */
export function usePlaybackInStep(
  recordings: readonly Played[],
  firstSpeed: number,
): PlaybackInStep {
  const { frame_rate_hz: rateHz } = useGame();
  const [speed, setSpeed] = useState(firstSpeed);
  const calm = useMedia("(prefers-reduced-motion: reduce)");
  const queries = useQueries({ queries: recordings.map((one) => framesQuery(one)) });
  const ready =
    queries.every(({ data, error }) => data ?? error) && queries.some(({ data }) => data);
  const last = Math.max(0, ...queries.map(({ data }) => data?.last ?? 0));
  const shown = recordings.map(({ frames_url: url }) => url).join();
  const playback = useMemo(
    () => (ready ? new Playback(last, rateHz) : null),
    // Other recordings begin anew, even if they are as long.
    // eslint-disable-next-line react-hooks/exhaustive-deps
    [ready, last, rateHz, shown],
  );
  useEffect(() => {
    if (!playback) return undefined;
    playback.setSpeed(speed);
    if (calm) playback.seek(last);
    else playback.play();
    return () => playback.pause();
    // A change of the speed is the playback's own and does not begin anew.
    // eslint-disable-next-line react-hooks/exhaustive-deps
  }, [playback, calm, last]);
  return { playback, last, screens: queries.map(screensOf), setSpeed };
}

function screensOf({ data, error, refetch }: UseQueryResult<RecordedFrames>): Screens {
  return { frames: data, error, retry: () => void refetch() };
}
