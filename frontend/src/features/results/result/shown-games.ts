/** Which games a result opens with: one of the imitator's and the person's best. */
import type { EvaluationGame, Recording, RunResults } from "@/api/types";
import type { Actor } from "@/lib/actors";

/** A game that plays in step with another. */
export interface ShownGame {
  readonly actor: Actor;
  /** "Imitator", "Person, best game". */
  readonly name: string;
  readonly recording: Recording;
}

interface ShownGames {
  readonly imitator: EvaluationGame;
  /** Null if the run has no demonstration. */
  readonly best: Recording | null;
}

/** Returns the games that a result opens with; null before the imitator has played. */
export function shownGames({
  games,
  shown_game: shown,
  best_demonstration: best,
}: RunResults): ShownGames | null {
  const imitator = games.find(({ recording }) => recording.id === shown);
  return imitator ? { imitator, best } : null;
}
