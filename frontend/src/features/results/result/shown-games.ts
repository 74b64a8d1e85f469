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

/**
 * Returns the imitator's greedy game whose start is nearest to that of the best demonstration, from
 * a start that no training game began from if there is one; null before it has played. How it went
 * does not count.
 */
export function shownGames({ games, best_demonstration: best }: RunResults): ShownGames | null {
  const greedy = games.filter(
    ({ policy, action_selection: how }) => policy === "imitator" && how === "greedy",
  );
  const heldOut = greedy.filter((one) => one.held_out);
  const candidates = heldOut.length > 0 ? heldOut : greedy;
  const [first, ...others] = candidates;
  if (!first) return null;
  const distance = ({ recording }: EvaluationGame) =>
    best ? startDistance(recording.start, best.start) : 0;
  const imitator = others.reduce(
    (nearest, one) => (distance(one) < distance(nearest) ? one : nearest),
    first,
  );
  return { imitator, best };
}

type Start = Recording["start"];

/** Returns how far apart two starts are: the sum of the differences of what they set. */
function startDistance(one: Start, other: Start): number {
  const names = new Set([...Object.keys(one), ...Object.keys(other)]);
  return [...names].reduce((sum, name) => sum + Math.abs((one[name] ?? 0) - (other[name] ?? 0)), 0);
}
