import { t } from "@lingui/core/macro";

import { ColourBar, OpacitySlider } from "@/components/attention/AttentionKey";
import { Choice } from "@/components/attention/Choice";
import { followsBy } from "@/components/attention/words";

import type { LookingNetwork } from "./choice";
import styles from "./WatchedAttention.module.css";

const NOTHING = "nothing";

const options = () =>
  [
    { id: NOTHING, name: t`Picture only` },
    { id: "policy", name: t`What imitator and clone look at` },
    { id: "reward", name: t`What the reward looks at` },
  ] as const;

interface WatchedAttentionProps {
  network: LookingNetwork | null;
  onNetwork: (network: LookingNetwork | null) => void;
  opacity: number;
  onOpacity: (opacity: number) => void;
}

/** Chooses what lies over the pictures of the watched games. */
export function WatchedAttention(props: WatchedAttentionProps) {
  const { network, onNetwork, opacity, onOpacity } = props;
  return (
    <div className={styles.attention} role="group" aria-label={t`Attention`}>
      <Choice
        label={t`Over the picture`}
        options={options()}
        value={network ?? NOTHING}
        onChange={(chosen) => onNetwork(chosen === NOTHING ? null : chosen)}
      />
      {network !== null && (
        <>
          <ColourBar most={t`most in each game`} />
          <OpacitySlider opacity={opacity} onOpacity={onOpacity} />
          <p>{followsBy(network === "reward")}</p>
        </>
      )}
    </div>
  );
}
