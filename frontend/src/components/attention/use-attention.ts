import { useQuery } from "@tanstack/react-query";
import { useState, useSyncExternalStore } from "react";

import { attentionQuery } from "@/api/runs";
import type { Playback } from "@/lib/game/playback";
import { stepOf } from "@/lib/recordings";
import { useSettled } from "@/lib/use-settled";

/** A state has to be shown for this long before its map is asked for, while a person scrubs. */
const SETTLED_MS = 60;

export interface Attention {
  readonly on: boolean;
  readonly toggle: () => void;
  /** The step of the state that is shown; null while the recording plays. */
  readonly step: number | null;
  /** The exact map where it is ready, else the quick one; undefined until then. */
  readonly map: Float32Array | undefined;
  readonly isExact: boolean;
  readonly error: Error | null;
}

interface Judged {
  readonly runId: string;
  readonly recordingId: number;
}

/**
 * What the reward looks at in the state that is shown: a quick map at once, then the exact one. Both
 * requests are cancelled when another state is shown.
 */
export function useAttention(judged: Judged | undefined, playback: Playback): Attention {
  const [on, setOn] = useState(false);
  const step = useSyncExternalStore(playback.subscribe, () => {
    const { playing, frame } = playback.snapshot();
    return playing ? null : stepOf(frame);
  });
  const settled = useSettled(step, SETTLED_MS);
  const wanted = on && step !== null && step === settled && judged !== undefined;
  const { runId, recordingId } = judged ?? { runId: "", recordingId: 0 };
  const quick = useQuery({
    ...attentionQuery(runId, recordingId, step ?? 0, "gradient"),
    enabled: wanted,
  });
  const exact = useQuery({
    ...attentionQuery(runId, recordingId, step ?? 0, "occlusion"),
    enabled: wanted && quick.isSuccess,
  });
  return {
    on,
    toggle: () => {
      if (!on) playback.pause();
      setOn(!on);
    },
    step,
    map: wanted ? (exact.data ?? quick.data) : undefined,
    isExact: wanted && exact.data !== undefined,
    error: wanted ? (quick.error ?? exact.error) : null,
  };
}
