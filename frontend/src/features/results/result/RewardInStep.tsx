import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQueries } from "@tanstack/react-query";
import { useMemo, useSyncExternalStore } from "react";

import { messageOf } from "@/api/client";
import { rewardTraceQuery } from "@/api/runs";
import type { RewardTrace } from "@/api/types";
import { Loading } from "@/components/feedback/States";
import { ActorMark } from "@/components/game/ActorMark";
import { HEIGHT, RewardPlot, stepAt } from "@/components/reward/RewardPlot";
import { useGame } from "@/games/game";
import { actorColour } from "@/lib/actors";
import { fixed } from "@/lib/format";
import type { Playback } from "@/lib/game/playback";
import { stepOf } from "@/lib/recordings";

import styles from "./RewardInStep.module.css";
import type { ShownGame } from "./shown-games";

interface RewardInStepProps {
  runId: string;
  games: readonly ShownGame[];
  playback: Playback;
  last: number;
}

/** R of each game on one scale, in step with the pictures. */
export function RewardInStep({ runId, games, playback, last }: RewardInStepProps) {
  const queries = useQueries({
    queries: games.map(({ recording }) => rewardTraceQuery(runId, recording.id)),
  });
  const error = queries.find((one) => one.error)?.error;
  const traces = queries.flatMap(({ data }) => (data ? [data] : []));
  if (error) {
    return (
      <p className={styles.missing} role="status">
        <Trans>R over time can&rsquo;t be shown: {messageOf(error)}</Trans>
      </p>
    );
  }
  if (traces.length < games.length)
    return <Loading what={t`the learned reward`} rows={1} height={`${HEIGHT}px`} />;
  return <Curves traces={traces} games={games} playback={playback} last={last} />;
}

function Curves({
  traces,
  games,
  playback,
  last,
}: Omit<RewardInStepProps, "runId"> & { traces: readonly RewardTrace[] }) {
  const game = useGame();
  const { frame } = useSyncExternalStore(playback.subscribe, playback.snapshot);
  const shown = traces.map((trace) => trace.recording_id).join();
  const curves = useMemo(
    () =>
      traces.map(({ levels }, index) => ({
        levels,
        colour: actorColour(games[index]?.actor ?? "person"),
      })),
    // Traces are immutable.
    // eslint-disable-next-line react-hooks/exhaustive-deps
    [shown],
  );
  const levels = traces.map(({ levels }) =>
    fixed(levels[stepAt(frame, levels.length, game)] ?? NaN, 2),
  );
  return (
    <div className={styles.reward}>
      <p className={styles.head}>
        <b>
          <Trans>Learned reward R</Trans>
        </b>
        {games.map(({ actor }, index) => (
          <ActorMark key={actor} actor={actor}>
            <b>{levels[index]}</b>
          </ActorMark>
        ))}
        <span className={styles.scale}>
          <Trans>0: how demonstrations begin, 1: how the best ones end</Trans>
        </span>
      </p>
      <RewardPlot
        curves={curves}
        playback={playback}
        last={last}
        valueAt={() =>
          [
            t`step ${stepOf(frame, game)}`,
            ...games.map(({ name }, index) => `${name} ${levels[index] ?? ""}`),
          ].join(", ")
        }
      />
    </div>
  );
}
