import { useMutation, useQuery, useQueryClient } from "@tanstack/react-query";
import { type SubmitEvent, useState } from "react";
import { Link, useNavigate } from "react-router";

import { messageOf } from "@/api/client";
import { createRun, recipesQuery } from "@/api/runs";
import { isAlive, systemQuery } from "@/api/system";
import type { Behaviour, Recipe } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Check, Field } from "@/components/controls/Field";
import { Failed, Loading, Notice } from "@/components/feedback/States";
import { ValueTable } from "@/components/ValueTable";
import { shortCount, whole } from "@/lib/format";
import { valueRows } from "@/lib/recipe-values";
import { estimateInWords, stageInWords, stageName } from "@/lib/runs";

import { defaultsOf, errorsIn, type FormErrors, type FormValues, readWhole, runOf } from "./form";
import styles from "./TrainPage.module.css";

/** Starts a run on the ranking as it stands. */
export function TrainPage({ behaviour }: { behaviour: Behaviour }) {
  const { data: recipes, error, refetch } = useQuery(recipesQuery);
  if (error && !recipes) {
    return <Failed what="The recipes" error={error} onRetry={() => void refetch()} />;
  }
  if (!recipes?.[0]) return <Loading what="the recipes" rows={3} />;
  return (
    <div className={styles.page}>
      <TrainForm behaviour={behaviour} recipes={recipes} first={recipes[0]} />
      <aside className={styles.side} aria-label="What a run does">
        <h2>What a run does</h2>
        <ol className={styles.stages}>
          {STAGES.map((stage, index) => (
            <li key={stage}>
              <span>{index + 1}</span>
              <span>
                <strong>{stageName(stage)}</strong>
                {stageInWords(stage)}
              </span>
            </li>
          ))}
        </ol>
        <p>
          A run works on the ranking as it is when you press the button. You can go on playing and
          ranking meanwhile.
        </p>
      </aside>
    </div>
  );
}

const STAGES = [
  "trajectories",
  "reward",
  "check",
  "clone",
  "imitator",
  "evaluation",
  "attention",
] as const;

function TrainForm({
  behaviour,
  recipes,
  first,
}: {
  behaviour: Behaviour;
  recipes: readonly Recipe[];
  first: Recipe;
}) {
  const client = useQueryClient();
  const navigate = useNavigate();
  const [values, setValues] = useState<FormValues>(() => defaultsOf(first));
  const [tried, setTried] = useState(false);
  const recipe = recipes.find(({ name }) => name === values.recipe) ?? first;
  const missing = missingFor(behaviour);
  const example = missing !== null && behaviour.ready_made && behaviour.n_recordings === 0;
  const errors = tried ? errorsIn(values) : {};

  const start = useMutation({
    mutationFn: createRun,
    onSuccess: async (run) => {
      await client.invalidateQueries({ queryKey: ["runs"] });
      await navigate(`/runs/${run.id}`);
    },
  });

  function change(part: Partial<FormValues>) {
    setValues((before) => ({ ...before, ...part }));
  }

  function submit(event: SubmitEvent) {
    event.preventDefault();
    setTried(true);
    const run = runOf(values, behaviour.id, example);
    if (run) start.mutate(run);
  }

  const steps = readWhole(values.steps);
  return (
    <form className={styles.form} onSubmit={submit} noValidate>
      <Readiness behaviour={behaviour} missing={missing} example={example} />
      <fieldset>
        <legend className={styles.legend}>Recipe</legend>
        <div className={styles.recipes}>
          {recipes.map((one) => (
            <RecipeChoice
              key={one.name}
              recipe={one}
              checked={one.name === recipe.name}
              onChoose={() => setValues({ ...defaultsOf(one), goOnAnyway: values.goOnAnyway })}
            />
          ))}
        </div>
      </fieldset>
      <Steps
        value={values.steps}
        error={errors.steps}
        recipe={recipe}
        onChange={(text) => change({ steps: text })}
      />
      <MoreSettings values={values} errors={errors} recipe={recipe} onChange={change} />
      {start.error && (
        <Notice tone="bad" live>
          <p>{messageOf(start.error)}</p>
        </Notice>
      )}
      <WorkerNotice />
      <div className={styles.start}>
        <Button
          kind="primary"
          large
          type="submit"
          disabled={start.isPending || (missing !== null && !example)}
        >
          {start.isPending ? "Starting…" : example ? "Train on the example" : "Train"}
        </Button>
        {steps > 0 && (
          <p className={styles.estimate}>
            <strong>{estimateInWords(recipe, steps)}</strong> on this machine
            <br />
            {whole(Math.round(recipe.steps_per_s))} steps/s,{" "}
            {recipe.steps_per_s_measured ? "as measured in earlier runs" : "a first guess"}
          </p>
        )}
      </div>
    </form>
  );
}

/** What keeps a run from being started; null if nothing does. */
function missingFor(behaviour: Behaviour): string | null {
  if (behaviour.n_ranked < 2) return "Rank at least two recordings, in two tiers or more.";
  if (behaviour.n_perfect < 1) {
    return "Mark at least one recording as perfect: the clone learns from those.";
  }
  return null;
}

function Readiness({
  behaviour,
  missing,
  example,
}: {
  behaviour: Behaviour;
  missing: string | null;
  example: boolean;
}) {
  const at = `/behaviours/${behaviour.id}`;
  if (missing === null) {
    return (
      <Notice tone="calm" icon="check">
        <p>
          {behaviour.n_ranked} ranked recordings and {behaviour.n_perfect} perfect ones go into the
          run. <Link to={`${at}/rank`}>Look at the ranking</Link>
        </p>
      </Notice>
    );
  }
  if (example) {
    return (
      <Notice tone="calm">
        <p>
          You have played nothing yet. The run below works on an example: a scripted player, not a
          person, makes the games and Tril ranks them.
        </p>
        <Link to={`${at}/play`}>Play yourself instead</Link>
      </Notice>
    );
  }
  return (
    <Notice>
      <p>{missing}</p>
      <Link to={`${at}/rank`}>Go to Rank</Link>
    </Notice>
  );
}

function RecipeChoice({
  recipe,
  checked,
  onChoose,
}: {
  recipe: Recipe;
  checked: boolean;
  onChoose: () => void;
}) {
  return (
    <label className={styles.recipe}>
      <input type="radio" name="recipe" value={recipe.name} checked={checked} onChange={onChoose} />
      <strong>{recipe.name}</strong>
      <span>{recipe.summary}</span>
    </label>
  );
}

const PRESETS = [20_000, 200_000, 500_000, 1_000_000, 10_000_000] as const;

function Steps({
  value,
  error,
  recipe,
  onChange,
}: {
  value: string;
  error: string | undefined;
  recipe: Recipe;
  onChange: (text: string) => void;
}) {
  return (
    <div>
      <Field
        label="Steps"
        error={error}
        hint="How many steps the imitator plays while it learns. More is slower and better."
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
      <div className={styles.presets} role="group" aria-label="Numbers of steps to choose from">
        {PRESETS.map((steps) => (
          <Button
            key={steps}
            aria-pressed={readWhole(value) === steps}
            title={estimateInWords(recipe, steps)}
            onClick={() => onChange(whole(steps))}
          >
            {shortCount(steps)}
          </Button>
        ))}
      </div>
    </div>
  );
}

function MoreSettings({
  values,
  errors,
  recipe,
  onChange,
}: {
  values: FormValues;
  errors: FormErrors;
  recipe: Recipe;
  onChange: (part: Partial<FormValues>) => void;
}) {
  return (
    <details className={styles.more}>
      <summary>More settings</summary>
      <div>
        <div className={styles.pair}>
          <Field label="Learning rate" error={errors.learningRate} hint="Of the imitator.">
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
            label="Training seed"
            error={errors.trainingSeed}
            hint="Feeds every random choice of learning."
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
        <Check
          label="Go on anyway"
          hint="A run stops after the check when the learned reward disagrees with the ranking. With this it trains the imitator all the same."
          checked={values.goOnAnyway}
          onChange={(goOnAnyway) => onChange({ goOnAnyway })}
        />
        <details className={styles.more}>
          <summary>All values of the recipe</summary>
          <div className={styles.values}>
            <ValueTable rows={valueRows(recipe.values)} label={`Values of ${recipe.name}`} />
          </div>
        </details>
      </div>
    </details>
  );
}

function WorkerNotice() {
  const { data: system } = useQuery(systemQuery);
  if (isAlive(system, "worker") !== false) return null;
  return (
    <Notice live>
      <p>
        The worker isn&rsquo;t running, so the run will wait in the queue. <code>tril up</code>{" "}
        starts it together with the server.
      </p>
    </Notice>
  );
}
