import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import { Button } from "@/components/controls/Button";

import styles from "./Attention.module.css";
import { attentionGradient } from "./colours";
import type { Attention } from "./use-attention";
import { describe, describeMost, lookedAt, methods, networks } from "./words";

interface AttentionPanelProps {
  attention: Attention;
  opacity: number;
  onOpacity: (opacity: number) => void;
}

/** The switch of the attention map, whose it is and how it is made, its colour bar and opacity. */
export function AttentionPanel({ attention, opacity, onOpacity }: AttentionPanelProps) {
  return (
    <div className={styles.panel}>
      <Button icon="eye" aria-pressed={attention.on} onClick={attention.toggle}>
        {lookedAt(attention.network)}
      </Button>
      {attention.on && (
        <>
          <Choice
            label={t`Whose attention`}
            options={networks()}
            value={attention.network}
            onChange={attention.setNetwork}
          />
          <Choice
            label={t`How it is mapped`}
            options={methods()}
            value={attention.method}
            onChange={attention.setMethod}
          />
          <span
            className={styles.bar}
            role="img"
            aria-label={t`Colours: from 0 to ${describeMost(attention)}`}
          >
            <span>0</span>
            <i style={{ backgroundImage: attentionGradient() }} />
            <span>{describeMost(attention)}</span>
          </span>
          <label className={styles.opacity}>
            <Trans>Opacity</Trans>
            <input
              type="range"
              min={0}
              max={100}
              value={Math.round(opacity * 100)}
              onChange={(event) => onOpacity(event.currentTarget.valueAsNumber / 100)}
              // The player moves through the recording by the same keys.
              onKeyDown={(event) => event.stopPropagation()}
            />
          </label>
          <p className={styles.state} role="status">
            {describe(attention)}
          </p>
        </>
      )}
    </div>
  );
}

function Choice<Id extends string>({
  label,
  options,
  value,
  onChange,
}: {
  label: string;
  options: readonly { readonly id: Id; readonly name: string }[];
  value: Id;
  onChange: (id: Id) => void;
}) {
  return (
    <label>
      <span className="visually-hidden">{label}</span>
      <select
        className={styles.choice}
        value={value}
        onChange={(event) => {
          const chosen = options.find(({ id }) => id === event.currentTarget.value);
          if (chosen) onChange(chosen.id);
        }}
      >
        {options.map(({ id, name }) => (
          <option key={id} value={id}>
            {name}
          </option>
        ))}
      </select>
    </label>
  );
}
