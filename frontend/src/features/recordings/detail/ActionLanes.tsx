import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { memo, useSyncExternalStore } from "react";

import { Legend } from "@/components/recording/Legend";
import { buttonName, describeAction, lanesOf } from "@/games/actions";
import { useGame } from "@/games/game";
import type { Playback } from "@/lib/game/playback";

import styles from "./ActionLanes.module.css";

const LANE_HEIGHT = 8;
const LANE_GAP = 3;

/** The keys held over time, and the action that led to the current frame. */
export function ActionLanes({
  playback,
  actions,
}: {
  playback: Playback;
  actions: readonly number[];
}) {
  const game = useGame();
  const { frame } = useSyncExternalStore(playback.subscribe, playback.snapshot);
  const last = Math.max(actions.length, 1);
  const names = game.buttons.map(buttonName).join(", ");
  const height = game.buttons.length * (LANE_HEIGHT + LANE_GAP);
  return (
    <div className={styles.actions}>
      <svg
        className={styles.lanes}
        viewBox={`0 0 ${last} ${height}`}
        height={height}
        preserveAspectRatio="none"
        role="img"
        aria-label={t`Keys held over time: ${names} from top to bottom`}
      >
        <Lanes actions={actions} last={last} />
        <line className={styles.cursor} x1={frame} x2={frame} y1={0} y2={height} />
      </svg>
      <Legend>
        <span>
          <Trans>Held: {names} from top to bottom</Trans>
        </span>
        <span>
          <Trans>
            Action of frame {frame}: <strong>{describeAction(actions, frame, game)}</strong>
          </Trans>
        </span>
      </Legend>
    </div>
  );
}

const Lanes = memo(function Lanes({ actions, last }: { actions: readonly number[]; last: number }) {
  const game = useGame();
  return lanesOf(actions, game).map((lane, index) => {
    const y = index * (LANE_HEIGHT + LANE_GAP);
    return (
      <g key={lane.button}>
        <rect className={styles.lane} x={0} y={y} width={last} height={LANE_HEIGHT} />
        {lane.spans.map(({ from, to }) => (
          <rect
            key={from}
            className={styles.held}
            x={from - 1}
            y={y}
            width={to - from + 1}
            height={LANE_HEIGHT}
          />
        ))}
      </g>
    );
  });
});
