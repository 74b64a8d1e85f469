import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { Fragment, useId } from "react";

import type { Behaviour, Recipe } from "@/api/types";
import { Badge } from "@/components/feedback/Badge";
import { describeEstimate, proposedSteps } from "@/lib/runs";

import { wordsOf } from "./recipe-words";
import styles from "./TrainForm.module.css";

interface RecipeCardProps {
  recipe: Recipe;
  behaviour: Behaviour;
  recommended: boolean;
  checked: boolean;
  onChoose: () => void;
}

/** A recipe to choose: when to take it, what it needs, how long it takes and what it gives. */
export function RecipeCard({ recipe, behaviour, recommended, checked, onChoose }: RecipeCardProps) {
  const id = useId();
  const { when, needs, gives } = wordsOf(recipe);
  const rows = [
    { term: t`Needs`, value: needs },
    { term: t`Takes`, value: describeEstimate(recipe, proposedSteps(recipe, behaviour)) },
    { term: t`Gives`, value: gives },
  ];
  return (
    <label className={styles.recipe}>
      <input
        type="radio"
        name="recipe"
        value={recipe.name}
        checked={checked}
        aria-labelledby={`${id}-name`}
        aria-describedby={`${id}-words`}
        onChange={onChoose}
      />
      <span id={`${id}-name`} className={styles.name}>
        <strong>{recipe.name}</strong>{" "}
        {recommended && (
          <Badge tone="good">
            <Trans>Recommended</Trans>
          </Badge>
        )}
      </span>
      <span id={`${id}-words`} className={styles.words}>
        <span>{when}</span>
        {rows.map(
          ({ term, value }) =>
            value !== null && (
              <Fragment key={term}>
                {" "}
                <span>
                  <b>{term}:</b> {value}.
                </span>
              </Fragment>
            ),
        )}
      </span>
    </label>
  );
}
