import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { RankingCheck } from "@/api/types";
import { measured } from "@/lib/format";
import { recordingName } from "@/lib/recordings";
import { playedBy } from "@/lib/things";

import styles from "./reward.module.css";
import { ScatterPlot } from "./ScatterPlot";

/** Predicted returns by tier, if any: decreasing if the reward model agrees with the ranking. */
export function ReturnsByTier({ returns }: { returns: RankingCheck["returns"] }) {
  if (returns.length === 0) return null;
  const tiers = Math.max(...returns.map(({ tier }) => tier), 2);
  return (
    <figure className={styles.scatter}>
      <figcaption>
        <Trans>Predicted return by tier, 1 is the best</Trans>
      </figcaption>
      <ScatterPlot
        label={t`Predicted return by tier`}
        range={[0.5, tiers + 0.5]}
        xTicks={Array.from({ length: tiers }, (_, index) => index + 1)}
        points={returns.map(({ tier, recording, predicted_return: value }) => ({
          key: recording.id,
          x: tier,
          y: value,
          thing: playedBy(recording.source),
          title: t`${recordingName(recording)}, tier ${tier}: ${measured(value)}`,
        }))}
      />
    </figure>
  );
}
