import { t } from "@lingui/core/macro";
import { useState } from "react";

import type { Measure } from "@/api/types";
import { Field } from "@/components/controls/Field";
import { unitOf } from "@/games/measures";

import styles from "./MeasureBuilder.module.css";

interface BoundsProps {
  measure: Measure;
  onChange: (measure: Measure) => void;
}

/** The lowest and the highest value that meet a measure; either may be left empty. */
export function Bounds({ measure, onChange }: BoundsProps) {
  const [unreadable, setUnreadable] = useState<string | null>(null);
  if (measure.kind === "alive") return null;
  // Shares are typed in percent.
  const scale = unitOf(measure) === "share" ? 100 : 1;
  const unit = unitName(measure);
  const bounds = [
    { key: "at_least", label: t`At least, ${unit}` },
    { key: "at_most", label: t`At most, ${unit}` },
  ] as const;
  return (
    <div className={styles.row}>
      {bounds.map(({ key, label }) => {
        const value = measure[key];
        return (
          <Field key={key} label={label} error={unreadable === key ? t`Type a number.` : null}>
            {(control) => (
              <input
                {...control}
                type="number"
                step="any"
                {...(scale === 100 && { min: 0, max: 100 })}
                value={value == null ? "" : Number((value * scale).toFixed(3))}
                onChange={(event) => {
                  const { valueAsNumber: typed, validity } = event.currentTarget;
                  setUnreadable(validity.badInput ? key : null);
                  onChange({ ...measure, [key]: Number.isFinite(typed) ? typed / scale : null });
                }}
              />
            )}
          </Field>
        );
      })}
    </div>
  );
}

function unitName(measure: Measure): string {
  switch (unitOf(measure)) {
    case "share":
      return measure.kind === "order" ? t`% of what is taken` : t`% of the time`;
    case "per_second":
      return t`times a second`;
    case "seconds":
      return t`seconds`;
    case "points":
      return t`points`;
    case "items":
    case "count":
    case "yes":
      return t`number`;
  }
}
