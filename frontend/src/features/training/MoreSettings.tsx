import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { Recipe } from "@/api/types";
import { Checkbox, Field } from "@/components/controls/Field";
import { ValueTable } from "@/components/ValueTable";
import { valueRows } from "@/lib/recipe-values";

import type { FormErrors, FormValues } from "./form";
import styles from "./MoreSettings.module.css";

interface MoreSettingsProps {
  values: FormValues;
  errors: FormErrors;
  recipe: Recipe;
  /** Whether it is unfolded at first. */
  open: boolean;
  onChange: (part: Partial<FormValues>) => void;
}

/** Learning rate, training seed, whether to ignore the check, and where the run may learn. */
export function MoreSettings({ values, errors, recipe, open, onChange }: MoreSettingsProps) {
  return (
    <details className={styles.more} open={open}>
      <summary>
        <Trans>More settings</Trans>
      </summary>
      <div>
        <div className={styles.pair}>
          <Field label={t`Learning rate`} error={errors.learningRate} hint={t`Of the imitator.`}>
            {(control) => (
              <input
                {...control}
                inputMode="decimal"
                autoComplete="off"
                value={values.learningRate}
                onChange={(event) => onChange({ learningRate: event.currentTarget.value })}
              />
            )}
          </Field>
          <Field
            label={t`Training seed`}
            error={errors.trainingSeed}
            hint={t`Seeds every random choice of learning.`}
          >
            {(control) => (
              <input
                {...control}
                inputMode="numeric"
                autoComplete="off"
                value={values.trainingSeed}
                onChange={(event) => onChange({ trainingSeed: event.currentTarget.value })}
              />
            )}
          </Field>
        </div>
        {/* The check stops no run by GAIL, which does not learn from the reward. */}
        {recipe.values.method !== "gail" && (
          <Checkbox
            label={t`Go on anyway`}
            hint={t`A run stops after the check if the learned reward disagrees with the ranking. With this box ticked, it trains the imitator anyway.`}
            checked={values.goOnAnyway}
            onChange={(goOnAnyway) => onChange({ goOnAnyway })}
          />
        )}
        <Checkbox
          label={t`Only on a GPU`}
          hint={t`The run waits for a worker that has one. Otherwise it learns on whatever the next free worker has.`}
          checked={values.onGpu}
          onChange={(onGpu) => onChange({ onGpu })}
        />
        <details className={styles.more}>
          <summary>
            <Trans>All values of the recipe</Trans>
          </summary>
          <div className={styles.values}>
            <ValueTable rows={valueRows(recipe.values)} label={t`Values of ${recipe.name}`} />
          </div>
        </details>
      </div>
    </details>
  );
}
