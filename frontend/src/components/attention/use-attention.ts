import { useQuery } from "@tanstack/react-query";
import { useState, useSyncExternalStore } from "react";

import {
  type AttentionMapValues,
  type AttentionMethod,
  type AttentionNetwork,
  attentionQuery,
} from "@/api/runs";
import type { Playback } from "@/lib/game/playback";
import { stepOf } from "@/lib/recordings";
import { useSettled } from "@/lib/use-settled";

/** A state has to be shown for this long before its map is asked for, while a person scrubs. */
const SETTLED_MS = 60;

export interface Attention {
  readonly on: boolean;
  readonly toggle: () => void;
  readonly network: AttentionNetwork;
  readonly setNetwork: (network: AttentionNetwork) => void;
  readonly method: AttentionMethod;
  readonly setMethod: (method: AttentionMethod) => void;
  /** The step of the state that is shown; null while the recording plays. */
  readonly step: number | null;
  /** The map by the chosen method where it is ready, else the quick one; undefined until then. */
  readonly map: AttentionMapValues | undefined;
  /** How that map was made. */
  readonly shown: AttentionMethod | null;
  readonly error: Error | null;
}

interface Judged {
  readonly runId: string;
  readonly recordingId: number;
}

/**
 * What a network looks at in the state that is shown: a quick map at once, then the one that is
 * chosen. Both requests are cancelled when another state is shown.
 */
export function useAttention(judged: Judged | undefined, playback: Playback): Attention {
  const [on, setOn] = useState(false);
  const [network, setNetwork] = useState<AttentionNetwork>("reward");
  const [method, setMethod] = useState<AttentionMethod>("occlusion");
  const step = useSyncExternalStore(playback.subscribe, () => {
    const { playing, frame } = playback.snapshot();
    return playing ? null : stepOf(frame);
  });
  const settled = useSettled(step, SETTLED_MS);
  const wanted = on && step !== null && step === settled && judged !== undefined;
  const { runId, recordingId } = judged ?? { runId: "", recordingId: 0 };
  const quick = useQuery({
    ...attentionQuery(runId, recordingId, step ?? 0, network, "gradient"),
    enabled: wanted,
  });
  const exact = useQuery({
    ...attentionQuery(runId, recordingId, step ?? 0, network, method),
    enabled: wanted && quick.isSuccess && method !== "gradient",
  });
  const isExact = method !== "gradient" && exact.data !== undefined;
  const map = wanted ? (isExact ? exact.data : quick.data) : undefined;
  return {
    on,
    toggle: () => {
      if (!on) playback.pause();
      setOn(!on);
    },
    network,
    setNetwork,
    method,
    setMethod,
    step,
    map,
    shown: map ? (isExact ? method : "gradient") : null,
    error: wanted ? (quick.error ?? exact.error) : null,
  };
}
