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
        What the reward looks at
      </Button>
      {attention.on && (
        <>
          <span className={styles.bar} role="img" aria-label="Colours: from nothing to most">
            <span>nothing</span>
            <i style={{ backgroundImage: attentionGradient() }} />
            <span>most</span>
          </span>
          <label className={styles.opacity}>
            Opacity
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
  if (step === null) return "Pause to see what the reward looks at.";
  if (error) return `The map can’t be shown: ${messageOf(error)}`;
  if (!map) return `Looking at step ${step}…`;
  if (isExact) return `Step ${step}, exact: how much R changes where 3×3 pixels are occluded.`;
  return `Step ${step}, estimated by the gradient of R; the exact map follows.`;
}
