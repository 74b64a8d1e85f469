import { t } from "@lingui/core/macro";
import { useQuery } from "@tanstack/react-query";
import { type ReactNode, useState } from "react";

import { behavioursQuery } from "@/api/behaviours";
import { catalogueQuery, gameQuery } from "@/games/catalogue";
import { fieldMessageOf } from "@/api/client";
import type { Behaviour, BehaviourNew, TaughtGame } from "@/api/types";
import type { Draft } from "@/components/controls/drafts";
import { Checkbox, Field } from "@/components/controls/Field";
import { FormDialog } from "@/components/controls/FormDialog";
import { GameProvider } from "@/games/game";
import { wordsOf } from "@/games/words";

import styles from "./BehaviourDialog.module.css";
import {
  type BehaviourDraft,
  behaviourOf,
  EMPTY_DRAFT,
  nameProblem,
  secondsProblem,
} from "./draft";
import { HowPlayed } from "./HowPlayed";
import { MeasureBuilder } from "./measures/MeasureBuilder";
import { ItemPicker } from "./target/ItemPicker";

const NO_SETTINGS = { options: {} };

interface BehaviourDialogProps {
  title: string;
  draft: Draft<BehaviourDraft>;
  onSubmit: (behaviour: BehaviourNew) => void;
  onClose: () => void;
  /** The behaviour that is being edited, which may keep its name. */
  edited?: Behaviour;
  /** Why target and settings can't be changed; they are not shown then. */
  fixed?: ReactNode;
  submit: string;
  pending: boolean;
  error: unknown;
  /** Further buttons, at the end of the row. */
  more?: ReactNode;
}

/** Edits what a behaviour is to show, its name, how it is played and its target. */
export function BehaviourDialog(props: BehaviourDialogProps) {
  const { draft, edited, fixed, error } = props;
  const { value } = draft;
  const { data: others } = useQuery(behavioursQuery);
  const { data: game, error: unknownGame } = useQuery(gameQuery(value.game));
  const [left, setLeft] = useState(false);
  const [refused, setRefused] = useState<string | null>(null);
  const set = (change: Partial<BehaviourDraft>) => draft.set({ ...value, ...change });

  const problem = nameProblem(value.name, others ?? [], edited?.id);
  // While an empty field has not been left, nothing is wrong with it yet.
  const said = value.name === "" && !left ? null : problem;
  const answered = fieldMessageOf(error, "name");
  const nameError = said ?? (refused === value.name ? answered : null);
  const noTarget = Boolean(game?.items) && value.hasTarget && value.target.length === 0;
  const tooLong = game ? secondsProblem(value.seconds, game) : null;

  function submit(form: HTMLFormElement) {
    setLeft(true);
    if (problem !== null || noTarget || tooLong !== null) {
      form.querySelectorAll("details").forEach((folded) => {
        if (folded.querySelector("[aria-invalid]")) folded.open = true;
      });
      form.querySelector<HTMLElement>("[aria-invalid], [data-empty] button")?.focus();
      return;
    }
    if (!game) return;
    setRefused(value.name);
    props.onSubmit(behaviourOf(value, game));
  }

  return (
    <FormDialog
      title={props.title}
      draft={draft}
      submit={props.submit}
      disabled={props.pending || !game}
      error={answered ? null : (error ?? unknownGame)}
      onSubmit={submit}
      onClose={props.onClose}
      more={props.more}
    >
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
      {!edited && (
        <GameField
          value={value.game}
          onChange={(name) => {
            // What was set of another game means nothing in this one.
            const { seconds, endRule, options, hasTarget, target, hidden, measures } = EMPTY_DRAFT;
            set({ game: name, seconds, endRule, options, hasTarget, target, hidden, measures });
          }}
        />
      )}
      {fixed ??
        (game && (
          <>
            <HowPlayed game={game} value={value} error={tooLong} onChange={set} />
            <Target game={game} value={value} noTarget={noTarget} onChange={set} />
          </>
        ))}
      {game && (
        <GameProvider game={game} settings={NO_SETTINGS}>
          <MeasureBuilder value={value.measures} onChange={(measures) => set({ measures })} />
        </GameProvider>
      )}
    </FormDialog>
  );
}

function GameField({ value, onChange }: { value: string; onChange: (name: string) => void }) {
  const { data: games } = useQuery(catalogueQuery);
  const sorted = [...(games ?? [])].sort((a, b) => a.title.localeCompare(b.title));
  return (
    <Field label={t`Game`}>
      {(control) => (
        <select
          {...control}
          value={value}
          onChange={(event) => onChange(event.currentTarget.value)}
        >
          {!games && <option value={value}>{t`Loading…`}</option>}
          {sorted.map(({ name, title }) => (
            <option key={name} value={name}>
              {title}
            </option>
          ))}
        </select>
      )}
    </Field>
  );
}

interface TargetProps {
  game: TaughtGame;
  value: BehaviourDraft;
  noTarget: boolean;
  onChange: (change: Partial<BehaviourDraft>) => void;
}

/** The items that are to be taken; nothing for a game without items. */
function Target({ game, value, noTarget, onChange }: TargetProps) {
  const { items } = game;
  if (!items) return null;
  const words = wordsOf(game);
  return (
    <div className={styles.target} data-empty={noTarget || undefined}>
      <Checkbox
        label={words.choosesTargets()}
        hint={t`Hits and strays are then counted. The imitator never sees this: it learns from your ranking and your perfect games.`}
        checked={value.hasTarget}
        onChange={(hasTarget) => onChange({ hasTarget })}
      />
      {value.hasTarget && (
        <>
          <ItemPicker
            game={game}
            items={items}
            value={value.target}
            onChange={(target) => onChange({ target })}
            ordered={value.ordered}
          />
          {noTarget && (
            <p className={styles.error} role="status">
              {words.noTarget()}
            </p>
          )}
          <Checkbox
            label={t`The order matters`}
            hint={t`Hit them in the order you pick them.`}
            checked={value.ordered}
            onChange={(ordered) => onChange({ ordered })}
          />
        </>
      )}
    </div>
  );
}
