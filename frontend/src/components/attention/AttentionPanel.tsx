import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import { messageOf } from "@/api/client";
import { Button } from "@/components/controls/Button";

import styles from "./Attention.module.css";
import { attentionGradient } from "./colours";
import type { Attention } from "./use-attention";

interface AttentionPanelProps {
  attention: Attention;
  opacity: number;
  onOpacity: (opacity: number) => void;
}

/** The switch of the attention map, its colour bar and its opacity. */
export function AttentionPanel({ attention, opacity, onOpacity }: AttentionPanelProps) {
  return (
    <div className={styles.panel}>
      <Button icon="eye" aria-pressed={attention.on} onClick={attention.toggle}>
        <Trans>What the reward looks at</Trans>
      </Button>
      {attention.on && (
        <>
          <span className={styles.bar} role="img" aria-label={t`Colours: from nothing to most`}>
            <span>
              <Trans>nothing</Trans>
            </span>
            <i style={{ backgroundImage: attentionGradient() }} />
            <span>
              <Trans>most</Trans>
            </span>
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

function describe({ step, map, isExact, error }: Attention): string {
  if (step === null) return t`Pause to see what the reward looks at.`;
  if (error) return t`The map can’t be shown: ${messageOf(error)}`;
  if (!map) return t`Looking at step ${step}…`;
  if (isExact) return t`Step ${step}, exact: how much R changes where 3×3 pixels are occluded.`;
  return t`Step ${step}, estimated by the gradient of R; the exact map follows.`;
}
