import { t } from "@lingui/core/macro";

import type { Recipe } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Field } from "@/components/controls/Field";
import { shortCount, whole } from "@/lib/format";
import { describeEstimate, proposedSteps } from "@/lib/runs";

import { readWhole } from "./form";
import styles from "./StepsField.module.css";

const PRESETS = [20_000, 200_000, 2_000_000, 10_000_000];

/** Presets within this factor of what the recipe proposes are left out. */
const APART = 1.5;

interface StepsFieldProps {
  value: string;
  error: string | undefined;
  recipe: Recipe;
  /** Whether targets are to be hit in order. */
  ordered: boolean;
  onChange: (text: string) => void;
}

/** The number of environment steps, typed or chosen from presets. */
export function StepsField({ value, error, recipe, ordered, onChange }: StepsFieldProps) {
  const proposed = proposedSteps(recipe, { ordered });
  const others = PRESETS.filter((steps) => steps > APART * proposed || proposed > APART * steps);
  const presets = [...others, proposed].sort((one, other) => one - other);
  return (
    <div>
      <Field
        label={t`Steps`}
        error={error}
        hint={
          ordered && recipe.ordered_steps > recipe.default_steps
            ? t`How many steps the imitator plays while it learns. More take longer and usually teach more; targets that must be hit in order need more.`
            : t`How many steps the imitator plays while it learns. More take longer and usually teach more.`
        }
      >
        {(control) => (
          <input
            {...control}
            inputMode="numeric"
            autoComplete="off"
            value={value}
            onChange={(event) => onChange(event.currentTarget.value)}
          />
        )}
      </Field>
      <div className={styles.presets} role="group" aria-label={t`Preset numbers of steps`}>
        {presets.map((steps) => (
          <Button
            key={steps}
            aria-pressed={readWhole(value) === steps}
            title={describeEstimate(recipe, steps)}
            onClick={() => onChange(whole(steps))}
          >
            {shortCount(steps)}
          </Button>
        ))}
      </div>
    </div>
  );
}
