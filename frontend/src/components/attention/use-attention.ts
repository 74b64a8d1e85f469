import { useQuery, useQueryClient } from "@tanstack/react-query";
import { useEffect, useState, useSyncExternalStore } from "react";

import {
  type AttentionMapValues,
  type AttentionMethod,
  type AttentionNetwork,
  attentionQuery,
} from "@/api/runs";
import { useGame } from "@/games/game";
import type { Playback } from "@/lib/game/playback";
import { stepOf } from "@/lib/recordings";
import { useSettled } from "@/lib/use-settled";

/** A state has to be shown for this long before its map is asked for, while a person scrubs. */
const SETTLED_MS = 60;

/** Between the maps of a recording that plays, each of the newest state. */
const REST_MS = 50;
/** Before another try after one that failed. */
const RETRY_MS = 2000;

export interface Attention {
  readonly on: boolean;
  readonly toggle: () => void;
  readonly network: AttentionNetwork;
  readonly setNetwork: (network: AttentionNetwork) => void;
  readonly method: AttentionMethod;
  readonly setMethod: (method: AttentionMethod) => void;
  /** Whether the recording plays, so that quick maps follow it. */
  readonly playing: boolean;
  /** The step that the map is of; null while the recording plays and none is there yet. */
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
 * chosen. Both requests are cancelled when another state is shown. While the recording plays, quick
 * maps follow it one after the other.
 */
export function useAttention(judged: Judged | undefined, playback: Playback): Attention {
  const game = useGame();
  const [on, setOn] = useState(false);
  const [network, setNetwork] = useState<AttentionNetwork>("reward");
  const [method, setMethod] = useState<AttentionMethod>("occlusion");
  const step = useSyncExternalStore(playback.subscribe, () => {
    const { playing, frame } = playback.snapshot();
    return playing ? null : stepOf(frame, game);
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
  const followed = useFollowed(on && step === null ? judged : undefined, network, playback);
  const map = wanted ? (isExact ? exact.data : quick.data) : followed.map;
  return {
    on,
    toggle: () => setOn(!on),
    network,
    setNetwork,
    method,
    setMethod,
    playing: step === null,
    step: step ?? followed.step,
    map,
    shown: map ? (wanted && isExact ? method : "gradient") : null,
    error: wanted ? (quick.error ?? exact.error) : followed.error,
  };
}

interface Followed {
  readonly step: number | null;
  readonly map: AttentionMapValues | undefined;
  readonly error: Error | null;
}

const NOTHING: Followed = { step: null, map: undefined, error: null };

/** Quick maps of a recording that plays; nothing without one. */
function useFollowed(
  judged: Judged | undefined,
  network: AttentionNetwork,
  playback: Playback,
): Followed {
  const game = useGame();
  const queries = useQueryClient();
  const [followed, setFollowed] = useState(NOTHING);
  const { runId, recordingId } = judged ?? { runId: "", recordingId: 0 };
  const follows = judged !== undefined;
  useEffect(() => {
    if (!follows) return undefined;
    let timer: ReturnType<typeof setTimeout> | undefined;
    let over = false;
    const next = async () => {
      const step = stepOf(playback.snapshot().frame, game);
      const query = attentionQuery(runId, recordingId, step, network, "gradient");
      let rest = REST_MS;
      try {
        const map = await queries.query(query);
        if (!over) setFollowed({ step, map, error: null });
      } catch (problem) {
        rest = RETRY_MS;
        if (!over) setFollowed({ ...NOTHING, error: problem as Error });
      }
      if (!over) timer = setTimeout(() => void next(), rest);
    };
    void next();
    return () => {
      over = true;
      clearTimeout(timer);
      setFollowed(NOTHING);
    };
  }, [follows, runId, recordingId, network, playback, queries, game]);
  return followed;
}
