/** Games as the API describes them, written by the server's tests. */
import { readFileSync } from "node:fs";
import { resolve } from "node:path";

import type { TaughtGame, Title } from "@/api/types";

const games = JSON.parse(
  readFileSync(resolve(import.meta.dirname, "../../../tests/data/games.json"), "utf8"),
) as Record<string, TaughtGame>;

function gameNamed(name: string): TaughtGame {
  const game = games[name];
  if (!game) throw new Error(`There is no game ${name} in tests/data/games.json.`);
  return game;
}

export const SPACE_INVADERS = gameNamed("space_invaders");

/** A joystick game without items, counters or a scripted player. */
export const PONG = gameNamed("pong");

/** A joystick with all directions. */
export const MS_PACMAN = gameNamed("ms_pacman");

/** An environment with colours of its own. */
export const CART_POLE = gameNamed("gym:CartPole-v1");

/** An environment whose buttons have names and no directions. */
export const BLACKJACK = gameNamed("gym:Blackjack-v1");

export function titleOf(game: TaughtGame, change: Partial<Title> = {}): Title {
  const { name, title, picture_url } = game;
  return { name, title, picture_url, n_behaviours: 0, last_played_at: null, ...change };
}

/** Answers of a server that has these games. */
export function gameRoutes(...shown: readonly TaughtGame[]) {
  const all = shown.length > 0 ? shown : [SPACE_INVADERS];
  return {
    "GET /api/catalogue": () => all.map((game) => titleOf(game)),
    ...Object.fromEntries(
      all.map((game) => [`GET /api/catalogue/games/${encodeURIComponent(game.name)}`, () => game]),
    ),
  };
}
