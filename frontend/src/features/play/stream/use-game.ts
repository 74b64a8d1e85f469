import { useMutation } from "@tanstack/react-query";
import { useCallback, useEffect, useRef, useState, useSyncExternalStore } from "react";

import { isNotFound } from "@/api/client";
import { FRAME_RATE_HZ } from "@/lib/format";

import { type GameScreen, type GameState, GameStream, newTabId, streamUrl } from "./game-stream";
import { createGame, createGameFrom, getGame } from "./games";
import type { Ended } from "./text-messages";

const TAB = newTabId();
const NO_GAME = () => () => undefined;

/** Where this tab remembers the game it plays, so that a reload goes on with it. */
function memoryKey(behaviourId: number): string {
  return `tril.game.${behaviourId}`;
}

export interface PlayedGame {
  /** Null before the first game. */
  readonly state: GameState | null;
  readonly stream: GameStream | null;
  readonly starting: boolean;
  readonly error: unknown;
  /** Begins a new game. */
  start: () => void;
  /** Begins a game that goes on from shortly before the end of another one. */
  goOnFrom: (ended: Ended) => void;
  /** Back to before the first game. */
  clear: () => void;
}

/** Plays games of a behaviour, one after the other, on one screen. */
export function useGame(behaviourId: number, screen: GameScreen): PlayedGame {
  const [stream, setStream] = useState<GameStream | null>(null);
  const current = useRef<GameStream | null>(null);

  const play = useCallback(
    (gameId: string, streamPath: string) => {
      remember(behaviourId, gameId);
      const speed = current.current?.snapshot().speed;
      current.current?.leave();
      const next = new GameStream(streamUrl(streamPath, TAB), screen, speed);
      current.current = next;
      next.connect();
      setStream(next);
    },
    [behaviourId, screen],
  );

  const create = useMutation({
    mutationFn: (from: Ended | null) =>
      from ? createGameFrom(from.recording_id, lastChanceOf(from)) : createGame(behaviourId),
    onSuccess: (game) => play(game.id, game.stream_path),
  });

  // A game that a reload interrupted goes on.
  useEffect(() => {
    const gameId = sessionStorage.getItem(memoryKey(behaviourId));
    let stale = false;
    if (gameId) {
      getGame(gameId).then(
        (game) => {
          if (!stale && !current.current) play(game.id, game.stream_path);
        },
        (error: unknown) => {
          if (isNotFound(error)) forget(behaviourId);
        },
      );
    }
    return () => {
      stale = true;
      current.current?.leave();
      current.current = null;
    };
  }, [behaviourId, play]);

  const state = useSyncExternalStore<GameState | null>(
    stream?.subscribe ?? NO_GAME,
    () => stream?.snapshot() ?? null,
  );
  const phase = state?.phase;
  useEffect(() => {
    if (phase === "ended" || phase === "gone") forget(behaviourId);
  }, [behaviourId, phase]);

  const clear = useCallback(() => {
    current.current?.leave();
    current.current = null;
    setStream(null);
  }, []);

  return {
    state,
    stream,
    starting: create.isPending,
    error: create.error,
    start: () => {
      if (!create.isPending) create.mutate(null);
    },
    goOnFrom: (ended) => {
      if (!create.isPending) create.mutate(ended);
    },
    clear,
  };
}

const CHANCE_FRAMES = 2 * FRAME_RATE_HZ;

/** From which frame an ended game can be played on, in time to do something else. */
export function lastChanceOf({ frame }: Pick<Ended, "frame">): number {
  return Math.max(0, frame - CHANCE_FRAMES);
}

function remember(behaviourId: number, gameId: string): void {
  try {
    sessionStorage.setItem(memoryKey(behaviourId), gameId);
  } catch {
    // Storage is closed: a reload begins anew, and the interrupted game stays on the server.
  }
}

function forget(behaviourId: number): void {
  try {
    sessionStorage.removeItem(memoryKey(behaviourId));
  } catch {
    // Storage is closed, so there is nothing to forget.
  }
}
