/** Decides which of two games is better: more targets, then fewer strays, else a tie. */
import type { ComparisonRow, EvaluationGame } from "@/api/types";

type Winner = ComparisonRow["winner"];

export function winnerOf(
  imitator: EvaluationGame | undefined,
  clone: EvaluationGame | undefined,
): Winner {
  const ours = imitator?.recording;
  const theirs = clone?.recording;
  if (!ours || !theirs || ours.targets === null || theirs.targets === null) return null;
  const ahead = ours.targets - theirs.targets || (theirs.strays ?? 0) - (ours.strays ?? 0);
  if (ahead === 0) return "tie";
  return ahead > 0 ? "imitator" : "clone";
}

/** Returns rows for the greedy games whose starts are not shown yet. */
export function furtherRows(
  games: readonly EvaluationGame[],
  shown: readonly ComparisonRow[],
): readonly ComparisonRow[] {
  const done = new Set(shown.map((row) => row.start_number));
  const greedy = games.filter(
    (game) => game.action_selection === "greedy" && !done.has(game.start_number),
  );
  const starts = [...new Set(greedy.map((game) => game.start_number))].sort((a, b) => a - b);
  return starts.map((start) => {
    const from = greedy.filter((game) => game.start_number === start);
    const imitator = from.find((game) => game.policy === "imitator");
    const clone = from.find((game) => game.policy === "clone");
    return {
      start_number: start,
      held_out: from.every((game) => game.held_out),
      imitator: imitator ?? null,
      clone: clone ?? null,
      winner: winnerOf(imitator, clone),
    };
  });
}
