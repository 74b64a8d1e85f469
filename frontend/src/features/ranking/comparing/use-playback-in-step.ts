import { useQuery } from "@tanstack/react-query";
import { useEffect, useMemo, useState } from "react";

import { framesQuery } from "@/api/recordings";
import type { Recording } from "@/api/types";
import { useMedia } from "@/features/ranking/use-media";
import { useGame } from "@/games/game";
import type { RecordedFrames } from "@/lib/game/codec";
import { Playback } from "@/lib/game/playback";

/** Fast, since most pairs are told apart by where they end. */
const FIRST_SPEED = 2;

/** The screens of a recording, or why they are missing. */
export interface Screens {
  readonly frames: RecordedFrames | undefined;
  readonly error: unknown;
  readonly retry: () => void;
}

interface PlaybackInStep {
  /** Of both recordings; the shorter one stops at its end. Null until both can be played. */
  readonly playback: Playback | null;
  /** The last frame of the longer one. */
  readonly last: number;
  readonly screens: readonly [Screens, Screens];
  readonly setSpeed: (speed: number) => void;
}

/**
 * Plays two recordings in step from their beginning, as soon as both are there. Where the system
 * asks for less motion, it shows how they end and waits.
 */
export function usePlaybackInStep(left: Recording, right: Recording): PlaybackInStep {
  const { frame_rate_hz: rateHz } = useGame();
  const [speed, setSpeed] = useState(FIRST_SPEED);
  const calm = useMedia("(prefers-reduced-motion: reduce)");
  const queries = [useQuery(framesQuery(left)), useQuery(framesQuery(right))] as const;
  const [first, second] = queries.map(({ data }) => data);
  const ready = queries.every(({ data, error }) => data ?? error) && Boolean(first ?? second);
  const last = Math.max(first?.last ?? 0, second?.last ?? 0);
  const playback = useMemo(
    () => (ready ? new Playback(last, rateHz) : null),
    // Another pair begins anew, even if it is as long.
    // eslint-disable-next-line react-hooks/exhaustive-deps
    [ready, last, rateHz, first, second],
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
  const [one, other] = queries;
  return { playback, last, screens: [screensOf(one), screensOf(other)], setSpeed };
}

function screensOf({
  data,
  error,
  refetch,
}: {
  data: RecordedFrames | undefined;
  error: unknown;
  refetch: () => unknown;
}): Screens {
  return { frames: data, error, retry: () => void refetch() };
}
