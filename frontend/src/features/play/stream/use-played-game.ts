import { useMutation } from "@tanstack/react-query";
import { useCallback, useEffect, useRef, useState, useSyncExternalStore } from "react";

import { isNotFound } from "@/api/client";
import { useGame } from "@/games/game";
import { newUuid } from "@/lib/browser/uuid";
import { ofTab } from "@/lib/browser/storage";

import type { GameState } from "./game-state";
import { type GameScreen, GameStream } from "./game-stream";
import { createGame, createGameFrom, getGame } from "./games";
import { streamUrl } from "./tab";
import type { Ended } from "./text-messages";

const TAB = newUuid();
const NO_GAME = () => () => undefined;

/** The storage key of the tab's game, which a reload rejoins. */
function storageKey(behaviourId: number): string {
  return `tril.game.${behaviourId}`;
}

export interface PlayedGame {
  /** Null before the first game. */
  readonly state: GameState | null;
  readonly stream: GameStream | null;
  readonly starting: boolean;
  readonly error: unknown;
  /** Starts a new game. */
  start: () => void;
  /** Starts a game that continues another from shortly before its end. */
  continueFrom: (ended: Ended) => void;
}

/** Plays games of a behaviour on one screen, one after the other. */
export function usePlayedGame(behaviourId: number, screen: GameScreen): PlayedGame {
  const { frame_rate_hz: rateHz } = useGame();
  const [stream, setStream] = useState<GameStream | null>(null);
  const current = useRef<GameStream | null>(null);

  const play = useCallback(
    (gameId: string, streamPath: string) => {
      rememberGame(behaviourId, gameId);
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
      from
        ? createGameFrom(from.recording_id, resumeFrameOf(from, rateHz))
        : createGame(behaviourId),
    onSuccess: (game) => play(game.id, game.stream_path),
  });

  // Rejoin the game that a reload interrupted.
  useEffect(() => {
    const gameId = ofTab.read(storageKey(behaviourId));
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

  return {
    state,
    stream,
    starting: create.isPending,
    error: create.error,
    start: () => {
      if (!create.isPending) create.mutate(null);
    },
    continueFrom: (ended) => {
      if (!create.isPending) create.mutate(ended);
    },
  };
}

const RESUME_S = 2;

/** Returns the frame to resume an ended game from, early enough to act differently. */
export function resumeFrameOf({ frame }: Pick<Ended, "frame">, rateHz: number): number {
  return Math.max(0, frame - RESUME_S * rateHz);
}

/** Lets the play page of a behaviour join a game as soon as it is shown. */
export function rememberGame(behaviourId: number, gameId: string): void {
  ofTab.write(storageKey(behaviourId), gameId);
}

function forget(behaviourId: number): void {
  ofTab.remove(storageKey(behaviourId));
}
