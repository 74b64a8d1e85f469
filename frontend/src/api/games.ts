import { api, unwrap } from "./client";
import type { Game } from "./types";

/** A new game of a behaviour, from a start that the server draws. */
export function createGame(behaviourId: number): Promise<Game> {
  return unwrap(api.POST("/api/games", { body: { behaviour_id: behaviourId } }));
}

export function getGame(gameId: string): Promise<Game> {
  return unwrap(
    api.GET("/api/games/{game_id}", { params: { path: { game_id: gameId } } }),
  );
}
