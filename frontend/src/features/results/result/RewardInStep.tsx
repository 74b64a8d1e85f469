import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQueries } from "@tanstack/react-query";
import { type CSSProperties, useMemo, useSyncExternalStore } from "react";

import { messageOf } from "@/api/client";
import { rewardTraceQuery } from "@/api/runs";
import type { RewardTrace } from "@/api/types";
import { Loading } from "@/components/feedback/States";
import { HEIGHT, RewardPlot, scaleOf, stepAt } from "@/components/reward/RewardPlot";
import { useGame } from "@/games/game";
import { actorColour, actorNames } from "@/lib/actors";
import { fixed } from "@/lib/format";
import type { Playback } from "@/lib/game/playback";
import { stepOf } from "@/lib/recordings";
import { spreadLabels } from "@/features/results/labels/spread-labels";

import styles from "./RewardInStep.module.css";
import type { ShownGame } from "./shown-games";

/** Height of a curve's name and value. */
const LABEL_PX = 32;

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
  const tops = useMemo(() => {
    const y = scaleOf(curves);
    const ends = curves.map(({ levels }) => y(levels.at(-1) ?? 0));
    return spreadLabels(ends, Array<number>(ends.length).fill(LABEL_PX), HEIGHT);
  }, [curves]);
  return (
    <div className={styles.reward}>
      <p className={styles.head}>
        <b>
          <Trans>Learned reward R</Trans>
        </b>
        <span className={styles.scale}>
          <Trans>0: nothing reached, 1: as in the best games</Trans>
        </span>
      </p>
      <div className={styles.plotted}>
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
        <ul className={styles.ends} style={{ "--label": `${LABEL_PX}px` } as CSSProperties}>
          {games.map(({ actor }, index) => (
            <li key={actor} style={{ color: actorColour(actor), marginBlockStart: tops[index] }}>
              {actorNames()[actor]}
              <b>{levels[index]}</b>
            </li>
          ))}
        </ul>
      </div>
    </div>
  );
}
