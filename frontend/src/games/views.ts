/** The games that the page knows more of than the server tells. */
import { spaceInvaders } from "./space-invaders/view";
import type { GameView } from "./view";

const VIEWS: Readonly<Record<string, GameView>> = { space_invaders: spaceInvaders };

/** Returns what the page knows of a game; null if nothing. */
export function viewOf(name: string): GameView | null {
  return Object.hasOwn(VIEWS, name) ? (VIEWS[name] ?? null) : null;
}
