import { t } from "@lingui/core/macro";

import type { Measure } from "@/api/types";
import { Checkbox, Field } from "@/components/controls/Field";
import { AreaEditor } from "@/features/behaviours/hidden/AreaEditor";
import { AreaFields } from "@/features/behaviours/hidden/AreaFields";
import { ItemPicker } from "@/features/behaviours/target/ItemPicker";
import { buttonName } from "@/games/actions";
import { useGame } from "@/games/game";
import { countersOf, thingTitle } from "@/games/measures";
import { capitalised, wordsOf } from "@/games/words";

import { type OrderName, orderOf, orders } from "./drafts";
import styles from "./MeasureBuilder.module.css";

interface QuantityProps {
  measure: Measure;
  onChange: (measure: Measure) => void;
}

/** What exactly is measured, by the kind of the measure. */
export function Quantity(props: QuantityProps) {
  switch (props.measure.kind) {
    case "region":
      return <Region {...props} />;
    case "nearness":
      return <Nearness {...props} />;
    case "items":
      return <Items {...props} />;
    case "order":
      return <Order {...props} />;
    case "rate":
      return <Rate {...props} />;
    case "counter":
      return <Counter {...props} />;
    case "score":
    case "alive":
    case "length":
      return null;
  }
}

function Region({ measure, onChange }: QuantityProps) {
  const game = useGame();
  const area = measure.area ?? [0, 0, game.width, game.height];
  const set = ([left, top, right, bottom]: readonly [number, number, number, number]) =>
    onChange({ ...measure, area: [left, top, right, bottom] });
  return (
    <>
      <ThingChoice
        label={t`Thing`}
        value={measure.thing}
        onChange={(thing) => onChange({ ...measure, thing })}
      />
      <div className={styles.picture}>
        <AreaEditor
          areas={[area]}
          readOnly={false}
          outlined
          onChange={(areas) => set(areas.at(-1) ?? area)}
        />
        <AreaFields area={area} readOnly={false} onChange={set} />
      </div>
    </>
  );
}

function Nearness({ measure, onChange }: QuantityProps) {
  const axes = [
    { value: "both", name: t`in any direction` },
    { value: "x", name: t`sideways` },
    { value: "y", name: t`in height` },
  ] as const;
  return (
    <div className={styles.row}>
      <ThingChoice
        label={t`Thing`}
        value={measure.thing}
        besides={measure.other}
        onChange={(thing) => onChange({ ...measure, thing })}
      />
      <ThingChoice
        label={t`Other thing`}
        value={measure.other}
        besides={measure.thing}
        onChange={(other) => onChange({ ...measure, other })}
      />
      <Field label={t`Apart at most, in pixels`}>
        {(control) => (
          <input
            {...control}
            type="number"
            min={0}
            max={1000}
            step="any"
            value={measure.distance_px ?? ""}
            onChange={(event) => {
              const typed = event.currentTarget.valueAsNumber;
              if (Number.isFinite(typed)) onChange({ ...measure, distance_px: typed });
            }}
          />
        )}
      </Field>
      <Choice
        label={t`Direction`}
        value={measure.axes ?? "both"}
        options={axes}
        onChange={(chosen) => onChange({ ...measure, axes: chosen })}
      />
    </div>
  );
}

function Items({ measure, onChange }: QuantityProps) {
  const game = useGame();
  if (!game.items) return null;
  const cells = measure.cells ?? null;
  return (
    <>
      <Checkbox
        label={t`Only certain ones count`}
        checked={cells !== null}
        onChange={(certain) => onChange({ ...measure, cells: certain ? [[0, 0]] : null })}
      />
      {cells !== null && (
        <ItemPicker
          game={game}
          items={game.items}
          value={cells}
          // None at all would measure nothing.
          onChange={(chosen) =>
            onChange({
              ...measure,
              cells: chosen.length > 0 ? chosen.map(([row, column]) => [row, column]) : null,
            })
          }
          ordered={false}
        />
      )}
    </>
  );
}

const orderNames = (): Readonly<Record<OrderName, string>> => ({
  "rows-up": t`row by row, from the bottom`,
  "rows-down": t`row by row, from the top`,
  left: t`column by column, from the left`,
  right: t`column by column, from the right`,
  outside: t`columns from the outside in`,
  inside: t`columns from the inside out`,
});

function Order({ measure, onChange }: QuantityProps) {
  const game = useGame();
  const chosen = orderOf(measure.sequences, game);
  const options = orders(game).map(({ name }) => ({ value: name, name: orderNames()[name] }));
  return (
    <Choice<OrderName | "">
      label={wordsOf(game).takenTitle()}
      value={chosen ?? ""}
      options={chosen === null ? [{ value: "", name: t`in another order` }, ...options] : options}
      onChange={(name) => {
        const order = orders(game).find((one) => one.name === name);
        if (order) onChange({ ...measure, sequences: order.sequences });
      }}
    />
  );
}

function Rate({ measure, onChange }: QuantityProps) {
  const game = useGame();
  const buttons = game.buttons.map((name) => ({ value: name, name: buttonName(name) }));
  const others = measure.action == null ? [] : [{ value: "", name: t`Action ${measure.action}` }];
  return (
    <div className={styles.row}>
      <Choice
        label={t`Button`}
        value={measure.button ?? ""}
        options={[...others, ...buttons]}
        onChange={(button) => {
          if (button) onChange({ ...measure, button, action: null });
        }}
      />
      <Choice
        label={t`Counted`}
        value={measure.per ?? "second"}
        options={[
          { value: "second", name: t`how often it is pressed` },
          { value: "time", name: t`how long it is held` },
        ]}
        // A bound of the one means nothing of the other.
        onChange={(per) => onChange({ ...measure, per, at_least: null, at_most: null })}
      />
    </div>
  );
}

function Counter({ measure, onChange }: QuantityProps) {
  const options = countersOf(useGame()).map(([value, name]) => ({
    value,
    name: capitalised(name),
  }));
  return (
    <Choice
      label={t`Counted`}
      value={measure.counter ?? ""}
      options={options}
      onChange={(counter) => onChange({ ...measure, counter })}
    />
  );
}

interface ThingChoiceProps {
  label: string;
  value: string | null | undefined;
  /** A thing that can't be chosen. */
  besides?: string | null | undefined;
  onChange: (name: string) => void;
}

function ThingChoice({ label, value, besides, onChange }: ThingChoiceProps) {
  const game = useGame();
  const options = Object.keys(game.things)
    .filter((name) => name !== besides)
    .map((name) => ({ value: name, name: capitalised(thingTitle(name, game)) }));
  return <Choice label={label} value={value ?? ""} options={options} onChange={onChange} />;
}

interface ChoiceProps<Value extends string> {
  label: string;
  value: Value;
  options: readonly { readonly value: Value; readonly name: string }[];
  onChange: (value: Value) => void;
}

function Choice<Value extends string>({ label, value, options, onChange }: ChoiceProps<Value>) {
  return (
    <Field label={label}>
      {(control) => (
        <select
          {...control}
          value={value}
          onChange={(event) => {
            const chosen = options.find((one) => one.value === event.currentTarget.value);
            if (chosen) onChange(chosen.value);
          }}
        >
          {options.map((one) => (
            <option key={one.value} value={one.value}>
              {one.name}
            </option>
          ))}
        </select>
      )}
    </Field>
  );
}
