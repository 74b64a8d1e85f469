import { t } from "@lingui/core/macro";

import type { RankingCheck } from "@/api/types";
import { recordingName } from "@/lib/recordings";
import { playedBy } from "@/lib/actors";

import { judgedBy, type Measure, write } from "./measure";
import styles from "./reward.module.css";
import { ScatterPlot } from "./ScatterPlot";

interface RewardByTierProps {
  returns: RankingCheck["returns"];
  measure: Measure;
  /** What it is called. */
  name: string;
}

/** What ranked games are judged by, by tier: decreasing if the reward agrees with the ranking. */
export function RewardByTier({ returns, measure, name }: RewardByTierProps) {
  if (returns.length === 0) return null;
  const tiers = Math.max(...returns.map(({ tier }) => tier), 2);
  return (
    <figure className={styles.scatter}>
      <figcaption>{t`${name} by tier, 1 is the best`}</figcaption>
      <ScatterPlot
        label={t`${name} by tier`}
        measure={measure}
        range={[0.5, tiers + 0.5]}
        xTicks={Array.from({ length: tiers }, (_, index) => index + 1)}
        points={returns.map((one) => ({
          key: one.recording.id,
          x: one.tier,
          y: judgedBy(measure, one),
          actor: playedBy(one.recording.source),
          title: t`${recordingName(one.recording)}, tier ${one.tier}: ${write(measure, judgedBy(measure, one))}`,
        }))}
      />
    </figure>
  );
}
