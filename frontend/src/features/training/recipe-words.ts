/** What to know of a recipe before choosing it. */
import { t } from "@lingui/core/macro";

import type { Recipe } from "@/api/types";

export interface RecipeWords {
  /** When to choose it. */
  readonly when: string;
  /** Null where the recipe is not one of Tril's own. */
  readonly needs: string | null;
  readonly gives: string | null;
}

/** Describes a recipe in plain words; one that the page does not know has its summary. */
export function wordsOf({ name, summary }: Pick<Recipe, "name" | "summary">): RecipeWords {
  switch (name) {
    case "fast":
      return {
        when: t`Take it if your order is about what gets hit.`,
        needs: t`at least two ranked games; stars on the best ones help`,
        gives: t`an imitator that starts from a copy of your best games, and what should be hit`,
      };
    case "any":
      return {
        when: t`Take it for any goal, in any game.`,
        needs: t`at least two ranked games; more make it surer`,
        gives: t`an imitator that starts from a copy of your best games, and what your order is about in words`,
      };
    case "paper":
      return {
        when: t`Take it to repeat the published method.`,
        needs: t`at least two ranked games, and patience`,
        gives: t`an imitator that starts from nothing and learns from the screen alone`,
      };
    case "gail":
      return {
        when: t`Take it to see what your order adds: it learns without it.`,
        needs: t`stars on your best games, or the best ranked ones instead`,
        gives: t`an imitator that learns to be mistaken for your best games`,
      };
    default:
      return { when: summary, needs: null, gives: null };
  }
}
