import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { type ReactNode, useMemo, useSyncExternalStore } from "react";

import { messageOf } from "@/api/client";
import { rewardTraceQuery } from "@/api/runs";
import type { Recording, RewardTrace } from "@/api/types";
import { Loading, Notice } from "@/components/feedback/States";
import { Legend } from "@/components/recording/Legend";
import { useGame } from "@/games/game";
import { fixed, withDeviation } from "@/lib/format";
import type { Playback } from "@/lib/game/playback";

import styles from "./RewardCurve.module.css";
import { HEIGHT, RewardPlot, stepAt } from "./RewardPlot";

export interface ShownReward {
  /** The run whose reward model judges the recording. */
  readonly runId: string;
  readonly recordingId: number;
  /** Rendered in the curve's heading, such as a menu of runs. */
  readonly menu?: ReactNode;
}

interface RewardCurveProps {
  reward: ShownReward;
  playback: Playback;
  last: number;
  hits?: Recording["hits"] | undefined;
}

/** The level of the learned reward along a recording, in step with the picture. */
export function RewardCurve({ reward, playback, last, hits }: RewardCurveProps) {
  const { data, error } = useQuery(rewardTraceQuery(reward.runId, reward.recordingId));
  return (
    <section className={styles.reward} aria-label={t`Learned reward`}>
      <div className={styles.head}>
        <h3>
          <Trans>Learned reward</Trans>
        </h3>
        {reward.menu}
      </div>
      {data ? (
        <Curve trace={data} playback={playback} last={last} hits={hits} />
      ) : error ? (
        <Notice tone="calm" live>
          <p>
            <Trans>R over time can&rsquo;t be shown: {messageOf(error)}</Trans>
          </p>
        </Notice>
      ) : (
        <Loading what={t`the learned reward`} rows={1} height={`${HEIGHT}px`} />
      )}
    </section>
  );
}

interface CurveProps {
  trace: RewardTrace;
  playback: Playback;
  last: number;
  hits: Recording["hits"] | undefined;
}

function Curve({ trace, playback, last, hits }: CurveProps) {
  const game = useGame();
  const { frame } = useSyncExternalStore(playback.subscribe, playback.snapshot);
  const { levels, level_deviations: deviations } = trace;
  const curves = useMemo(() => [{ levels, deviations, hits }], [levels, deviations, hits]);
  const step = stepAt(frame, levels.length, game);
  const levelText = withDeviation(fixed(levels[step] ?? NaN, 2), deviations?.[step]);
  return (
    <>
      <RewardPlot
        curves={curves}
        playback={playback}
        last={last}
        valueAt={() => t`step ${step}, R ${levelText}`}
      />
      <Legend>
        <span>
          <Trans>
            R {levelText} at step {step}
          </Trans>
        </span>
        <span>
          <Trans>0: nothing reached, 1: as in the best games</Trans>
        </span>
        {deviations && (
          <span>
            <Trans>Band: ± one standard deviation, the larger the less the ranking says</Trans>
          </span>
        )}
      </Legend>
    </>
  );
}
