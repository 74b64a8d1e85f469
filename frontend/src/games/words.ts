/** The words for a game: its view's, or made of what the server tells. */
import { plural, t } from "@lingui/core/macro";

import type { TaughtGame } from "@/api/types";

import { viewOf } from "./views";
import type { GameWords } from "./view";

type Named = Pick<TaughtGame, "name" | "items" | "ends" | "end_rules">;

/** Returns the words for a game. */
export function wordsOf(game: Named): GameWords {
  return viewOf(game.name)?.words ?? plainWords(game);
}

/** Ends that many games have, which the page can say in its language. */
const commonEnds = (): Readonly<Record<string, string>> => ({
  life: t`a life was lost`,
  over: t`the game was over`,
});

/** The same of the rules by which games end. */
const commonRules = (): Readonly<Record<string, string>> => ({
  life: t`when a life is lost`,
  over: t`when the game is over`,
});

function plainWords({ items, ends, end_rules: rules }: Named): GameWords {
  const singular = items?.singular ?? "";
  const several = items?.plural ?? "";
  return {
    ends: () => ({
      ...Object.fromEntries(ends.map(({ name, sentence }) => [name, sentence])),
      ...commonEnds(),
    }),
    rules: () => ({
      ...Object.fromEntries(rules.map(({ name, title }) => [name, title])),
      ...commonRules(),
    }),
    titles: () => ({}),
    noneTaken: () => t`no ${several}`,
    takenTitle: () => capitalised(several),
    at: (cell) => capitalised(t`${singular} in ${cell}`),
    chosen: (count) => plural(count, { one: `# ${singular} chosen`, other: `# ${several} chosen` }),
    targets: () => t`Target ${several}`,
    choosesTargets: () => t`Target certain ${several}`,
    noTarget: () => t`Pick at least one ${singular}, or turn the target off.`,
  };
}

/** Begins a sentence with a phrase. */
export function capitalised(phrase: string): string {
  return phrase.charAt(0).toUpperCase() + phrase.slice(1);
}
