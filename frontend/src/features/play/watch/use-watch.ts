import { useEffect, useMemo, useRef, useState, useSyncExternalStore } from "react";

import type { Choice, LookingNetwork } from "./choice";
import { writeChoice } from "./choice";
import { type LaneScreen, type WatchState, WatchStream } from "./watch-stream";

const NOTHING = () => () => undefined;

/** Passes what a lane's stream shows on to the lane's view, which may mount later. */
export class LaneRelay implements LaneScreen {
  view: LaneScreen | null = null;
  private format: Parameters<LaneScreen["setFormat"]> | null = null;

  attach(view: LaneScreen): () => void {
    this.view = view;
    if (this.format) view.setFormat(...this.format);
    return () => {
      if (this.view === view) this.view = null;
    };
  }

  readonly setFormat = (...format: Parameters<LaneScreen["setFormat"]>): void => {
    this.format = format;
    this.view?.setFormat(...format);
  };

  readonly show = (...frame: Parameters<LaneScreen["show"]>): void => this.view?.show(...frame);

  readonly decide = (...decision: Parameters<LaneScreen["decide"]>): void =>
    this.view?.decide(...decision);

  readonly reward = (...reward: Parameters<LaneScreen["reward"]>): void =>
    this.view?.reward(...reward);

  readonly attend = (...attention: Parameters<LaneScreen["attend"]>): void =>
    this.view?.attend(...attention);
}

interface Watched {
  readonly state: WatchState | null;
  readonly stream: WatchStream | null;
  /** One for each game. */
  readonly relays: readonly LaneRelay[];
  /** Plays the same games again from their start; sampled ones with other actions. */
  restart: () => void;
  /** Whose attention lies over the games; null for none. */
  readonly attention: LookingNetwork | null;
  setAttention: (network: LookingNetwork | null) => void;
}

/** Watches what is chosen, and something else as soon as the choice changes. */
export function useWatch(runId: string, choice: Choice): Watched {
  const search = writeChoice(choice).toString();
  const nLanes = choice.players.length;
  const relays = useMemo(() => Array.from({ length: nLanes }, () => new LaneRelay()), [nLanes]);
  const [stream, setStream] = useState<WatchStream | null>(null);
  const [take, setTake] = useState(0);
  const [attention, setAttention] = useState<LookingNetwork | null>(null);
  const speed = useRef<number>(undefined);
  useEffect(() => {
    const next = new WatchStream(watchUrl(runId, search, take), relays, speed.current);
    next.connect();
    setStream(next);
    return () => {
      speed.current = next.snapshot().speed;
      next.leave();
    };
  }, [runId, search, take, relays]);
  useEffect(() => stream?.showAttention(attention), [stream, attention]);
  const state = useSyncExternalStore<WatchState | null>(
    stream?.subscribe ?? NOTHING,
    () => stream?.snapshot() ?? null,
  );
  const restart = () => setTake((before) => before + 1);
  return { state, stream, relays, restart, attention, setAttention };
}

/** Returns the URL of the stream; `take` draws sampled actions anew. */
function watchUrl(runId: string, search: string, take: number): string {
  const url = new URL(`/api/runs/${runId}/watch?${search}`, location.href);
  url.protocol = location.protocol === "https:" ? "wss:" : "ws:";
  url.searchParams.set("take", String(take));
  return url.href;
}
