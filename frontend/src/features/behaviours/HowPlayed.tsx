import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useState } from "react";

import type { TaughtGame } from "@/api/types";
import { Field } from "@/components/controls/Field";
import { wordsOf } from "@/games/words";

import styles from "./BehaviourDialog.module.css";
import { type BehaviourDraft, ownSeconds } from "./draft";

interface HowPlayedProps {
  game: TaughtGame;
  value: BehaviourDraft;
  /** What is wrong with the length. */
  error: string | null;
  onChange: (change: Partial<BehaviourDraft>) => void;
}

const optionNames = (): Readonly<Record<string, string>> => ({
  mode: t`Mode`,
  difficulty: t`Difficulty`,
});

/** When games end, how long they are, and the options of the game. */
export function HowPlayed({ game, value, error, onChange }: HowPlayedProps) {
  const options = Object.entries(game.options).filter(([, values]) => values.length > 1);
  const isChanged =
    value.seconds !== "" || value.endRule !== null || Object.keys(value.options).length > 0;
  // Afterwards it is as the person leaves it, also where a field is emptied.
  const [startsOpen] = useState(isChanged);
  return (
    <details className={styles.how} open={startsOpen}>
      <summary>
        <Trans>How it is played</Trans>
      </summary>
      <div className={styles.settings}>
        <p className={styles.note}>
          <Trans>This stays as it is once a game was recorded.</Trans>
        </p>
        <Field
          label={t`Longest game, in seconds`}
          hint={t`${ownSeconds(game)} unless you type another number.`}
          error={error}
        >
          {(control) => (
            <input
              {...control}
              inputMode="decimal"
              autoComplete="off"
              value={value.seconds}
              placeholder={ownSeconds(game)}
              onChange={(event) => onChange({ seconds: event.currentTarget.value })}
            />
          )}
        </Field>
        {game.end_rules.length > 1 && (
          <Field label={t`It also ends`}>
            {(control) => (
              <select
                {...control}
                value={value.endRule ?? game.end_rules[0]?.name}
                onChange={(event) => {
                  const rule = event.currentTarget.value;
                  onChange({ endRule: rule === game.end_rules[0]?.name ? null : rule });
                }}
              >
                {game.end_rules.map(({ name, title }) => (
                  <option key={name} value={name}>
                    {wordsOf(game).rules()[name] ?? title}
                  </option>
                ))}
              </select>
            )}
          </Field>
        )}
        {options.map(([name, values]) => (
          <Field key={name} label={optionNames()[name] ?? name}>
            {(control) => (
              <select
                {...control}
                value={value.options[name] ?? values[0]}
                onChange={(event) => {
                  const chosen = Number(event.currentTarget.value);
                  const others = Object.fromEntries(
                    Object.entries(value.options).filter(([other]) => other !== name),
                  );
                  onChange({
                    options: chosen === values[0] ? others : { ...others, [name]: chosen },
                  });
                }}
              >
                {values.map((one) => (
                  <option key={one} value={one}>
                    {one === values[0] ? t`${one}, as usual` : one}
                  </option>
                ))}
              </select>
            )}
          </Field>
        ))}
      </div>
    </details>
  );
}
