import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useMutation, useQuery, useQueryClient } from "@tanstack/react-query";
import type { SubmitEvent } from "react";
import { Link, useNavigate } from "react-router";

import { messageOf } from "@/api/client";
import { createRun, runQuery } from "@/api/runs";
import { isAlive, systemQuery } from "@/api/system";
import type { Behaviour, Recipe } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { useDraft, useHasDraft } from "@/components/controls/drafts";
import { Notice } from "@/components/feedback/States";
import { RunName } from "@/components/RunName";
import { whole } from "@/lib/format";
import { describeEstimate, isActive, proposedSteps } from "@/lib/runs";

import { defaultsOf, errorsIn, type FormValues, readWhole, runOf } from "./form";
import { MoreSettings } from "./MoreSettings";
import { missingFor, Readiness } from "./Readiness";
import { RecipeCard } from "./RecipeCard";
import { StepsField } from "./StepsField";
import styles from "./TrainForm.module.css";

interface TrainFormProps {
  behaviour: Behaviour;
  recipes: readonly Recipe[];
  /** The recipe that is chosen at first. */
  first: Recipe;
  /** Settings that the address fills in. */
  filledIn: Partial<FormValues>;
  /** The run whose imitator is trained further. */
  parentId: string | null;
  onParentRemoved: () => void;
}

/** The recipe and settings of a run. */
export function TrainForm(props: TrainFormProps) {
  const { behaviour, recipes, first, filledIn, parentId, onParentRemoved } = props;
  const client = useQueryClient();
  const navigate = useNavigate();
  /** The recipe, and what the user has edited, which is kept when the recipe changes. */
  const draft = useDraft<{ chosen: string; edits: Partial<FormValues> }>(
    `train ${behaviour.id} ${first.name} ${JSON.stringify(filledIn)}`,
    { chosen: first.name, edits: filledIn },
  );
  const { chosen, edits } = draft.value;
  const isOrderUnsaved = useHasDraft(`ranking ${behaviour.id}`);
  const { data: parent } = useQuery({ ...runQuery(parentId ?? ""), enabled: parentId !== null });
  const cancelParent = parent !== undefined && isActive(parent);
  const recipe = recipes.find(({ name }) => name === chosen) ?? first;
  const values = { ...defaultsOf(recipe, behaviour), ...edits };
  const missing = missingFor(behaviour);
  const example = missing !== null && behaviour.built_in && behaviour.n_recordings === 0;
  const errors = errorsIn(values);

  const start = useMutation({
    mutationFn: createRun,
    onSuccess: async (run) => {
      draft.drop();
      await client.invalidateQueries({ queryKey: ["runs"] });
      await navigate(`/runs/${run.id}`);
    },
  });

  function change(part: Partial<FormValues>) {
    draft.set({ chosen, edits: { ...edits, ...part } });
  }

  function submit(event: SubmitEvent) {
    event.preventDefault();
    const run = runOf(values, behaviour.id, example, parentId, cancelParent);
    if (run) start.mutate(run);
    else showInvalid(event.currentTarget);
  }

  const steps = readWhole(values.steps);
  return (
    <form className={styles.form} onSubmit={submit} noValidate>
      <Readiness behaviour={behaviour} missing={missing} example={example} />
      {parentId !== null && (
        <Parent runId={parentId} active={cancelParent} onRemove={onParentRemoved} />
      )}
      <fieldset>
        <legend className={styles.legend}>
          <Trans>Recipe</Trans>
        </legend>
        <div className={styles.recipes}>
          {recipes.map((one, index) => (
            <RecipeCard
              key={one.name}
              recipe={one}
              behaviour={behaviour}
              recommended={index === 0}
              checked={one === recipe}
              onChoose={() => draft.set({ chosen: one.name, edits })}
            />
          ))}
        </div>
      </fieldset>
      {recipe.name === "fast" && recipe !== recipes[0] && (
        <ItemsAlone proposed={recipes[0]?.name} />
      )}
      <StepsField
        value={values.steps}
        error={errors.steps}
        recipe={recipe}
        ordered={behaviour.ordered}
        onChange={(text) => change({ steps: text })}
      />
      {steps > 0 && steps <= recipe.warm_up_steps && (
        <TooShort recipe={recipe} behaviour={behaviour} />
      )}
      <MoreSettings
        values={values}
        errors={errors}
        recipe={recipe}
        open={filledIn.trainingSeed !== undefined}
        onChange={change}
      />
      {start.error && (
        <Notice tone="bad" live>
          <p>{messageOf(start.error)}</p>
        </Notice>
      )}
      {isOrderUnsaved && (
        <Notice live>
          <p>
            <Trans>
              Your last order is not saved yet, and a run would learn from the one before.{" "}
              <Link to={`/behaviours/${behaviour.id}/rank`}>Save it under Rank.</Link>
            </Trans>
          </p>
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
          {start.isPending ? t`Starting…` : example ? t`Train on the example` : t`Train`}
        </Button>
        {errors.steps === undefined && (
          <p className={styles.estimate}>
            <Trans>
              <strong>{describeEstimate(recipe, steps)}</strong> on this machine
            </Trans>
            <br />
            <Trans>{whole(Math.round(recipe.steps_per_s))} steps/s</Trans>,{" "}
            {recipe.steps_per_s_measured ? t`as measured in earlier runs` : t`an initial estimate`}
          </p>
        )}
      </div>
    </form>
  );
}

/** Focuses the first invalid field, also if it is folded away. */
function showInvalid(form: Element): void {
  const field = form.querySelector<HTMLElement>("[aria-invalid]");
  const folded = field?.closest("details");
  if (folded) folded.open = true;
  field?.focus();
}

/** What fast can't learn, for behaviours that may be about something else. */
function ItemsAlone({ proposed }: { proposed: string | undefined }) {
  return (
    <Notice tone="calm">
      <p>
        <Trans>
          The recipe <strong>fast</strong> considers only what is hit. If you rank by something
          else, such as where you stand or how often you shoot, take the recipe{" "}
          <strong>{proposed}</strong>.
        </Trans>
      </p>
    </Notice>
  );
}

/** A run that ends before the imitator begins to learn. */
function TooShort({ recipe, behaviour }: { recipe: Recipe; behaviour: Behaviour }) {
  return (
    <Notice live>
      <p>
        <Trans>
          Too short: for the first {whole(recipe.warm_up_steps)} steps only the critic learns, and
          the imitator plays as it began. The recipe proposes{" "}
          {whole(proposedSteps(recipe, behaviour))}.
        </Trans>
      </p>
    </Notice>
  );
}

/** The run that this one continues. */
function Parent(props: { runId: string; active: boolean; onRemove: () => void }) {
  const { runId, active, onRemove } = props;
  return (
    <Notice tone="calm" icon="redo">
      <p>
        <Trans>
          Continues{" "}
          <Link to={`/runs/${runId}`}>
            <RunName id={runId} />
          </Link>
          : PPO begins with its imitator instead of the clone.
        </Trans>
        {active && (
          <>
            {" "}
            <Trans>
              That run still trains: it is cancelled when this one starts, and can be resumed.
            </Trans>
          </>
        )}
      </p>
      <Button kind="quiet" icon="close" onClick={onRemove}>
        <Trans>Begin with the clone</Trans>
      </Button>
    </Notice>
  );
}

function WorkerNotice() {
  const { data: system } = useQuery(systemQuery);
  if (isAlive(system, "worker") !== false) return null;
  return (
    <Notice live>
      <p>
        <Trans>
          The worker isn&rsquo;t running, so the run will wait in the queue. <code>tril up</code>{" "}
          starts it together with the server.
        </Trans>
      </p>
    </Notice>
  );
}
