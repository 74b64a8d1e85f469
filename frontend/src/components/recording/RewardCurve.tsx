import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { memo, type PointerEvent, type ReactNode, useSyncExternalStore } from "react";

import { messageOf } from "@/api/client";
import { rewardTraceQuery } from "@/api/runs";
import type { Recording, RewardTrace, TaughtGame } from "@/api/types";
import { Loading, Notice } from "@/components/feedback/States";
import { useGame } from "@/games/game";
import { classes } from "@/lib/classes";
import { fixed, measured, withDeviation } from "@/lib/format";
import type { Playback } from "@/lib/game/playback";
import { stepOf } from "@/lib/recordings";

import { Legend } from "./Legend";
import styles from "./RewardCurve.module.css";
import { describeHit } from "./Scrubber";

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
export function RewardCurve({ reward, playback, last, hits = [] }: RewardCurveProps) {
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

const HEIGHT = 96;
/** Room above and below the curve, for the cursor's dot. */
const PADDING = 6;

interface CurveProps {
  trace: RewardTrace;
  playback: Playback;
  last: number;
  hits: Recording["hits"];
}

function Curve({ trace, playback, last, hits }: CurveProps) {
  const game = useGame();
  const { levels, rewards } = trace;
  const levelDeviations = trace.level_deviations;
  const { frame } = useSyncExternalStore(playback.subscribe, playback.snapshot);
  const step = stepAt(frame, levels.length, game);
  const level = levels[step] ?? NaN;
  const seek = (event: PointerEvent<HTMLDivElement>) => {
    const box = event.currentTarget.getBoundingClientRect();
    playback.pause();
    playback.seek(((event.clientX - box.left) / Math.max(box.width, 1)) * last);
  };
  const y = scaleOf(levels, levelDeviations);
  const levelText = withDeviation(fixed(level, 2), levelDeviations?.[step]);
  const rewardText = withDeviation(measured(rewards[step] ?? NaN), trace.reward_deviations?.[step]);
  return (
    <>
      <div
        className={styles.plot}
        style={{ height: HEIGHT }}
        role="slider"
        tabIndex={0}
        aria-label={t`Position on the curve of R`}
        aria-valuemin={0}
        aria-valuemax={last}
        aria-valuenow={frame}
        aria-valuetext={t`step ${step}, level ${levelText}`}
        onPointerDown={(event) => {
          if (event.button !== 0) return;
          event.currentTarget.setPointerCapture(event.pointerId);
          seek(event);
        }}
        onPointerMove={(event) => {
          if (event.currentTarget.hasPointerCapture(event.pointerId)) seek(event);
        }}
      >
        <CurveLines levels={levels} deviations={levelDeviations} last={last} hits={hits} />
        <svg className={styles.layer} aria-hidden="true">
          <g className={styles.cursor}>
            <line x1={percentOf(frame, last)} x2={percentOf(frame, last)} y1="0" y2="100%" />
            <circle cx={percentOf(frame, last)} cy={y(level)} r={4} />
          </g>
        </svg>
      </div>
      <Legend>
        <span>
          <Trans>
            Level {levelText} (R {rewardText}) at step {step}
          </Trans>
        </span>
        <span>
          <Trans>0: how demonstrations begin, 1: how the best ones end</Trans>
        </span>
        {levelDeviations && (
          <span>
            <Trans>Band: ± one standard deviation, the larger the less the ranking says</Trans>
          </span>
        )}
      </Legend>
    </>
  );
}

interface CurveLinesProps extends Pick<CurveProps, "last" | "hits"> {
  levels: readonly number[];
  /** Their standard deviations, where the reward model knows them. */
  deviations: readonly number[] | null;
}

const CurveLines = memo(function CurveLines({ levels, deviations, last, hits }: CurveLinesProps) {
  const game = useGame();
  const y = scaleOf(levels, deviations);
  const at = (level: number, step: number) =>
    `${Math.min(step * game.frames_per_step, last)} ${y(level).toFixed(2)}`;
  const points = levels.map(at);
  const band = deviations && [
    ...levels.map((level, step) => at(level + (deviations[step] ?? 0), step)),
    ...levels.map((level, step) => at(level - (deviations[step] ?? 0), step)).reverse(),
  ];
  return (
    <>
      <svg
        className={styles.layer}
        viewBox={`0 0 ${Math.max(last, 1)} ${HEIGHT}`}
        preserveAspectRatio="none"
        aria-hidden="true"
      >
        {[0, 1].map((level) => (
          <line key={level} className={styles.grid} x1={0} x2={last} y1={y(level)} y2={y(level)} />
        ))}
        {band && <path className={styles.band} d={`M${band.join("L")}Z`} />}
        <path className={styles.line} d={`M${points.join("L")}`} />
      </svg>
      {[0, 1].map((level) => (
        <span key={level} className={styles.tick} style={{ top: y(level) }} aria-hidden="true">
          {level}
        </span>
      ))}
      <svg className={styles.layer} aria-hidden="true">
        {hits.map((hit) => (
          <svg
            key={`${hit.frame}-${hit.row}-${hit.column}`}
            x={percentOf(hit.frame, last)}
            y={y(levels[stepAt(hit.frame, levels.length, game)] ?? 0)}
            overflow="visible"
          >
            <path
              className={classes(styles.hit, hit.on_target === false && styles.stray)}
              d={hit.on_target === false ? CROSS : RING}
            >
              <title>{describeHit(hit, game)}</title>
            </path>
          </svg>
        ))}
      </svg>
    </>
  );
});

/** Rings for hits and crosses for strays, distinguishable without colour. */
const RING = "M0-4.5A4.5 4.5 0 1 0 0 4.5 4.5 4.5 0 1 0 0-4.5";
const CROSS = "M-4-4 4 4M4-4-4 4";

/** Returns the vertical position of a level; 0, 1 and the band are always within the plot. */
function scaleOf(
  levels: readonly number[],
  deviations: readonly number[] | null,
): (level: number) => number {
  const around = (sign: 1 | -1) =>
    levels.map((level, step) => level + sign * (deviations?.[step] ?? 0));
  const low = Math.min(0, ...around(-1));
  const high = Math.max(1, ...around(1));
  return (level) => HEIGHT - PADDING - ((level - low) / (high - low)) * (HEIGHT - 2 * PADDING);
}

/** Returns the step whose state a frame shows or follows. */
function stepAt(frame: number, nLevels: number, game: TaughtGame): number {
  return Math.min(stepOf(frame, game), nLevels - 1);
}

function percentOf(frame: number, last: number): string {
  return `${(frame / Math.max(last, 1)) * 100}%`;
}
