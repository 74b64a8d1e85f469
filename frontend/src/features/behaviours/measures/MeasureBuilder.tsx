import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { Measure } from "@/api/types";
import { Button, IconButton } from "@/components/controls/Button";
import { Field } from "@/components/controls/Field";
import { useGame } from "@/games/game";
import { measureSentence } from "@/games/measures";

import { Bounds } from "./Bounds";
import { type Kind, kindsOf, MOST_MEASURES, newMeasure } from "./drafts";
import styles from "./MeasureBuilder.module.css";
import { Quantity } from "./Quantity";

interface MeasureBuilderProps {
  value: readonly Measure[];
  onChange: (value: readonly Measure[]) => void;
}

const kindNames = (): Readonly<Record<Kind, string>> => ({
  region: t`A place on the screen`,
  nearness: t`Two things near each other`,
  items: t`How much is taken`,
  order: t`In which order it is taken`,
  rate: t`How often a button is pressed`,
  counter: t`Something that is counted`,
  score: t`The score`,
  alive: t`Being alive at the end`,
  length: t`How long the game lasts`,
});

/** Edits what tells in numbers how well a game shows a behaviour. */
export function MeasureBuilder({ value, onChange }: MeasureBuilderProps) {
  const game = useGame();
  const kinds = kindsOf(game);
  const replace = (index: number, measure: Measure) =>
    onChange(value.map((old, at) => (at === index ? measure : old)));
  return (
    <details className={styles.measures} open={value.length > 0 || undefined}>
      <summary>
        <Trans>Measure how well a game shows it</Trans>
      </summary>
      <p className={styles.note}>
        <Trans>
          Every game is checked, yours and the imitator&rsquo;s. The imitator never sees this: it
          learns from your ranking and your perfect games.
        </Trans>
      </p>
      {value.map((measure, index) => (
        <fieldset key={index} className={styles.measure}>
          <legend>{measureSentence(measure, game)}</legend>
          <div className={styles.head}>
            <Field label={t`What is measured`}>
              {(control) => (
                <select
                  {...control}
                  value={measure.kind}
                  onChange={(event) => {
                    const kind = kinds.find((one) => one === event.currentTarget.value);
                    if (kind) replace(index, newMeasure(kind, game));
                  }}
                >
                  {kinds.map((kind) => (
                    <option key={kind} value={kind}>
                      {kindNames()[kind]}
                    </option>
                  ))}
                </select>
              )}
            </Field>
            <IconButton
              icon="trash"
              label={t`Remove measure ${index + 1}`}
              onClick={() => onChange(value.filter((_, at) => at !== index))}
            />
          </div>
          <Quantity measure={measure} onChange={(next) => replace(index, next)} />
          <Bounds measure={measure} onChange={(next) => replace(index, next)} />
        </fieldset>
      ))}
      <Button
        icon="plus"
        disabled={value.length >= MOST_MEASURES}
        onClick={() => onChange([...value, newMeasure(kinds[0] ?? "score", game)])}
      >
        <Trans>Measure something</Trans>
      </Button>
    </details>
  );
}
