import { t } from "@lingui/core/macro";

import { Button } from "@/components/controls/Button";
import { useGame } from "@/games/game";

import styles from "./Attention.module.css";
import { ColourBar, OpacitySlider } from "./AttentionKey";
import { Choice } from "./Choice";
import type { Attention } from "./use-attention";
import { describe, describeMost, lookedAt, methods, networks } from "./words";

interface AttentionPanelProps {
  attention: Attention;
  opacity: number;
  onOpacity: (opacity: number) => void;
}

/** The switch of the attention map, whose it is and how it is made, its colour bar and opacity. */
export function AttentionPanel({ attention, opacity, onOpacity }: AttentionPanelProps) {
  const game = useGame();
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
          <ColourBar most={describeMost(attention)} />
          <OpacitySlider opacity={opacity} onOpacity={onOpacity} />
          <p className={styles.state} role="status">
            {describe(attention, game)}
          </p>
        </>
      )}
    </div>
  );
}
