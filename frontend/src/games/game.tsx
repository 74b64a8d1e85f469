/** The game of a page, as a behaviour sets it. */
import { createContext, type ReactNode, useContext, useMemo } from "react";

import type { Behaviour, TaughtGame } from "@/api/types";

const GameContext = createContext<TaughtGame | null>(null);

/** Returns a game as a behaviour sets it: its length, its end and what stays hidden. */
export function asSet(game: TaughtGame, settings: Behaviour["settings"]): TaughtGame {
  const { max_steps: steps, end_rule: rule, hidden } = settings;
  return {
    ...game,
    max_steps: steps ?? game.max_steps,
    hidden: hidden ?? game.hidden,
    end_rules: [...game.end_rules].sort(
      (a, b) => Number(b.name === rule) - Number(a.name === rule),
    ),
  };
}

/** Gives the game of a behaviour to everything in it. */
export function GameProvider({
  game,
  settings,
  children,
}: {
  game: TaughtGame;
  settings: Behaviour["settings"];
  children: ReactNode;
}) {
  const value = useMemo(() => asSet(game, settings), [game, settings]);
  return <GameContext value={value}>{children}</GameContext>;
}

/**
 * Returns the game of the page, as its behaviour sets it.
 *
 * @throws {Error} The page is of no game.
 */
export function useGame(): TaughtGame {
  const game = useContext(GameContext);
  if (!game) throw new Error("There is no game here: a GameProvider is missing.");
  return game;
}
