import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import styles from "./Attention.module.css";
import { attentionGradient } from "./colours";

/** The opacity that maps begin with. */
export const OPACITY = 0.8;

/** The colours of a map, from nothing to the most in it. */
export function ColourBar({ most }: { most: string }) {
  return (
    <span className={styles.bar} role="img" aria-label={t`Colours: from 0 to ${most}`}>
      <span>0</span>
      <i style={{ backgroundImage: attentionGradient() }} />
      <span>{most}</span>
    </span>
  );
}

/** How much of the picture a map hides. */
export function OpacitySlider({
  opacity,
  onOpacity,
}: {
  opacity: number;
  onOpacity: (opacity: number) => void;
}) {
  return (
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
  );
}
