import { useQuery } from "@tanstack/react-query";
import { type ReactNode, type SubmitEvent, useState } from "react";

import { behavioursQuery } from "@/api/behaviours";
import { fieldMessageOf, messageOf } from "@/api/client";
import type { Behaviour, BehaviourNew } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Checkbox, Field } from "@/components/controls/Field";
import { Notice } from "@/components/feedback/States";
import type { Cell } from "@/lib/game/aliens";

import { AlienPicker } from "./AlienPicker";
import styles from "./BehaviourForm.module.css";
import { type BehaviourDraft, nameProblem } from "./draft";

interface BehaviourFormProps {
  value: BehaviourDraft;
  onChange: (value: BehaviourDraft) => void;
  onSubmit: (behaviour: BehaviourNew) => void;
  onCancel: () => void;
  /** The behaviour that is being edited, which may keep its name. */
  edited?: Behaviour;
  /** Why the target can't be changed; it is not shown then. */
  fixedTarget?: ReactNode;
  submit: string;
  pending: boolean;
  error: unknown;
  /** Further buttons, at the end of the row. */
  children?: ReactNode;
}

/** The name, description and target of a behaviour. */
export function BehaviourForm(props: BehaviourFormProps) {
  const { value, onChange, edited, fixedTarget, pending, error } = props;
  const { data: others } = useQuery(behavioursQuery);
  const [left, setLeft] = useState(false);
  const [refused, setRefused] = useState<string | null>(null);
  const set = (change: Partial<BehaviourDraft>) => onChange({ ...value, ...change });

  const problem = nameProblem(value.name, others ?? [], edited?.id);
  // While an empty field has not been left, nothing is wrong with it yet.
  const said = value.name === "" && !left ? null : problem;
  const answered = fieldMessageOf(error, "name");
  const nameError = said ?? (refused === value.name ? answered : null);
  const noTarget = value.hasTarget && value.target.length === 0;

  function submit(event: SubmitEvent) {
    event.preventDefault();
    setLeft(true);
    if (problem !== null || noTarget) {
      event.currentTarget
        .querySelector<HTMLElement>("[aria-invalid], [data-empty] button")
        ?.focus();
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
    <form className={styles.form} onSubmit={submit} noValidate>
      <Field label="Name" error={nameError}>
        {(control) => (
          <input
            {...control}
            value={value.name}
            maxLength={120}
            placeholder="Stay on the left"
            onBlur={(event) => {
              // Cancel and Close need no name.
              if (event.relatedTarget?.tagName !== "BUTTON") setLeft(true);
            }}
            onChange={(event) => set({ name: event.currentTarget.value })}
          />
        )}
      </Field>
      <Field label="Description" hint="What a perfect game looks like, in a sentence or two.">
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
            label="Target certain aliens"
            hint="Hits and strays are then counted. The agent never sees this: it learns from your ranking and your perfect games."
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
                  Pick at least one alien, or turn the target off.
                </p>
              )}
              <Checkbox
                label="The order matters"
                hint="They are to be hit in the order in which you pick them."
                checked={value.ordered}
                onChange={(ordered) => set({ ordered })}
              />
            </>
          )}
        </div>
      )}
      {Boolean(error) && !answered && (
        <Notice tone="bad" live>
          <p>{messageOf(error)}</p>
        </Notice>
      )}
      <div className={styles.actions}>
        <Button kind="primary" type="submit" disabled={pending}>
          {props.submit}
        </Button>
        <Button kind="quiet" onClick={props.onCancel}>
          Cancel
        </Button>
        {props.children}
      </div>
    </form>
  );
}
