import { api, unwrap } from "@/api/client";
import type { Game } from "@/api/types";

/** Creates a game of a behaviour, from a start that the server draws. */
export function createGame(behaviourId: number): Promise<Game> {
  return unwrap(api.POST("/api/games", { body: { behaviour_id: behaviourId } }));
}

export function getGame(gameId: string): Promise<Game> {
  return unwrap(api.GET("/api/games/{game_id}", { params: { path: { game_id: gameId } } }));
}

/** Creates a game that continues a recording from a frame. */
export function createGameFrom(recordingId: number, frame: number): Promise<Game> {
  return unwrap(
    api.POST("/api/games/from/{recording_id}", {
      params: { path: { recording_id: recordingId } },
      body: { frame },
    }),
  );
}
