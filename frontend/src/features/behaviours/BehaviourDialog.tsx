import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { type ReactNode, useState } from "react";

import { behavioursQuery } from "@/api/behaviours";
import { fieldMessageOf } from "@/api/client";
import type { Behaviour, BehaviourNew } from "@/api/types";
import type { Draft } from "@/components/controls/drafts";
import { Checkbox, Field } from "@/components/controls/Field";
import { FormDialog } from "@/components/controls/FormDialog";
import type { Cell } from "@/lib/game/aliens";

import { AlienPicker } from "./AlienPicker";
import styles from "./BehaviourDialog.module.css";
import { type BehaviourDraft, nameProblem } from "./draft";

interface BehaviourDialogProps {
  title: string;
  draft: Draft<BehaviourDraft>;
  onSubmit: (behaviour: BehaviourNew) => void;
  onClose: () => void;
  /** The behaviour that is being edited, which may keep its name. */
  edited?: Behaviour;
  /** Why the target can't be changed; it is not shown then. */
  fixedTarget?: ReactNode;
  submit: string;
  pending: boolean;
  error: unknown;
  /** Further buttons, at the end of the row. */
  more?: ReactNode;
}

/** Edits the name, description and target of a behaviour. */
export function BehaviourDialog(props: BehaviourDialogProps) {
  const { draft, edited, fixedTarget, error } = props;
  const { value } = draft;
  const { data: others } = useQuery(behavioursQuery);
  const [left, setLeft] = useState(false);
  const [refused, setRefused] = useState<string | null>(null);
  const set = (change: Partial<BehaviourDraft>) => draft.set({ ...value, ...change });

  const problem = nameProblem(value.name, others ?? [], edited?.id);
  // While an empty field has not been left, nothing is wrong with it yet.
  const said = value.name === "" && !left ? null : problem;
  const answered = fieldMessageOf(error, "name");
  const nameError = said ?? (refused === value.name ? answered : null);
  const noTarget = value.hasTarget && value.target.length === 0;

  function submit(form: HTMLFormElement) {
    setLeft(true);
    if (problem !== null || noTarget) {
      form.querySelector<HTMLElement>("[aria-invalid], [data-empty] button")?.focus();
      return;
    }
    setRefused(value.name);
    props.onSubmit({
      name: value.name.trim(),
      description: value.description.trim(),
      target: value.hasTarget ? value.target.map(([row, column]: Cell) => [row, column]) : null,
      ordered: value.hasTarget && value.ordered,
    });
  }

  return (
    <FormDialog
      title={props.title}
      draft={draft}
      submit={props.submit}
      disabled={props.pending}
      error={answered ? null : error}
      onSubmit={submit}
      onClose={props.onClose}
      more={props.more}
    >
      <Field label={t`Name`} error={nameError}>
        {(control) => (
          <input
            {...control}
            value={value.name}
            placeholder={t`Stay on the left`}
            onBlur={(event) => {
              // Cancel and Close need no name.
              if (event.relatedTarget?.tagName !== "BUTTON") setLeft(true);
            }}
            onChange={(event) => set({ name: event.currentTarget.value })}
          />
        )}
      </Field>
      <Field label={t`Description`} hint={t`What a perfect game looks like, in a sentence or two.`}>
        {(control) => (
          <textarea
            {...control}
            rows={3}
            value={value.description}
            maxLength={2000}
            onChange={(event) => set({ description: event.currentTarget.value })}
          />
        )}
      </Field>
      {fixedTarget ?? (
        <div className={styles.target} data-empty={noTarget || undefined}>
          <Checkbox
            label={t`Target certain aliens`}
            hint={t`Hits and strays are then counted. The agent never sees this: it learns from your ranking and your perfect games.`}
            checked={value.hasTarget}
            onChange={(hasTarget) => set({ hasTarget })}
          />
          {value.hasTarget && (
            <>
              <AlienPicker
                value={value.target}
                onChange={(target) => set({ target })}
                ordered={value.ordered}
              />
              {noTarget && (
                <p className={styles.error} role="status">
                  <Trans>Pick at least one alien, or turn the target off.</Trans>
                </p>
              )}
              <Checkbox
                label={t`The order matters`}
                hint={t`They are to be hit in the order in which you pick them.`}
                checked={value.ordered}
                onChange={(ordered) => set({ ordered })}
              />
            </>
          )}
        </div>
      )}
    </FormDialog>
  );
}
