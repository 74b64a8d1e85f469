import { t } from "@lingui/core/macro";
import { type CSSProperties, memo, type PointerEvent, useSyncExternalStore } from "react";

import type { Recording, TaughtGame } from "@/api/types";
import { describeHit } from "@/components/recording/Scrubber";
import { useGame } from "@/games/game";
import { classes } from "@/lib/classes";
import type { Playback } from "@/lib/game/playback";
import { stepOf } from "@/lib/recordings";

import styles from "./RewardPlot.module.css";

export const HEIGHT = 96;
/** Room above and below the curves, for the cursor's dots. */
const PADDING = 6;

/** The level of the learned reward along a recording. */
export interface RewardLevels {
  readonly levels: readonly number[];
  /** Their standard deviations, where the reward model knows them; drawn as a band. */
  readonly deviations?: readonly number[] | null;
  readonly hits?: Recording["hits"] | undefined;
  /** As a CSS colour, where several are drawn. */
  readonly colour?: string;
}

interface RewardPlotProps {
  curves: readonly RewardLevels[];
  playback: Playback;
  /** The last frame of the longest recording. */
  last: number;
  /** Says what the curves show at a step. */
  valueAt: (step: number) => string;
}

/** Curves of the learned reward on a common scale, and the position of the picture on them. */
export function RewardPlot({ curves, playback, last, valueAt }: RewardPlotProps) {
  const game = useGame();
  const { frame } = useSyncExternalStore(playback.subscribe, playback.snapshot);
  const seek = (event: PointerEvent<HTMLDivElement>) => {
    const box = event.currentTarget.getBoundingClientRect();
    playback.pause();
    playback.seek(((event.clientX - box.left) / Math.max(box.width, 1)) * last);
  };
  const y = scaleOf(curves);
  const x = percentOf(frame, last);
  return (
    <div
      className={styles.plot}
      style={{ height: HEIGHT }}
      role="slider"
      tabIndex={0}
      aria-label={t`Position on the curve of R`}
      aria-valuemin={0}
      aria-valuemax={last}
      aria-valuenow={frame}
      aria-valuetext={valueAt(stepOf(frame, game))}
      onPointerDown={(event) => {
        if (event.button !== 0) return;
        event.currentTarget.setPointerCapture(event.pointerId);
        seek(event);
      }}
      onPointerMove={(event) => {
        if (event.currentTarget.hasPointerCapture(event.pointerId)) seek(event);
      }}
    >
      <CurveLines curves={curves} last={last} />
      <svg className={styles.layer} aria-hidden="true">
        <g className={styles.cursor}>
          <line x1={x} x2={x} y1="0" y2="100%" />
          {curves.map(({ levels, colour }, index) => {
            const step = stepAt(frame, levels.length, game);
            return (
              <circle
                key={index}
                style={colourOf(colour)}
                // A game that is over stays where it ended.
                cx={percentOf(Math.min(frame, (levels.length - 1) * game.frames_per_step), last)}
                cy={y(levels[step] ?? 0)}
                r={4}
              />
            );
          })}
        </g>
      </svg>
    </div>
  );
}

const CurveLines = memo(function CurveLines({
  curves,
  last,
}: Pick<RewardPlotProps, "curves" | "last">) {
  const game = useGame();
  const y = scaleOf(curves);
  const at = (level: number, step: number) =>
    `${Math.min(step * game.frames_per_step, last)} ${y(level).toFixed(2)}`;
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
        {curves.map(({ levels, deviations, colour }, index) => {
          const edge = (sign: 1 | -1) =>
            levels.map((level, step) => at(level + sign * (deviations?.[step] ?? 0), step));
          return (
            <g key={index} style={colourOf(colour)}>
              {deviations && (
                <path
                  className={styles.band}
                  d={`M${[...edge(1), ...edge(-1).reverse()].join("L")}Z`}
                />
              )}
              <path className={styles.line} d={`M${levels.map(at).join("L")}`} />
            </g>
          );
        })}
      </svg>
      {[0, 1].map((level) => (
        <span key={level} className={styles.tick} style={{ top: y(level) }} aria-hidden="true">
          {level}
        </span>
      ))}
      <svg className={styles.layer} aria-hidden="true">
        {curves.flatMap(({ levels, hits = [] }) =>
          hits.map((hit) => (
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
          )),
        )}
      </svg>
    </>
  );
});

/** Rings for hits and crosses for strays, distinguishable without colour. */
const RING = "M0-4.5A4.5 4.5 0 1 0 0 4.5 4.5 4.5 0 1 0 0-4.5";
const CROSS = "M-4-4 4 4M4-4-4 4";

function colourOf(colour: string | undefined): CSSProperties {
  return { "--curve": colour } as CSSProperties;
}

/** Returns the vertical position of a level; 0, 1 and the bands are always within the plot. */
export function scaleOf(curves: readonly RewardLevels[]): (level: number) => number {
  const around = (sign: 1 | -1) =>
    curves.flatMap(({ levels, deviations }) =>
      levels.map((level, step) => level + sign * (deviations?.[step] ?? 0)),
    );
  const low = Math.min(0, ...around(-1));
  const high = Math.max(1, ...around(1));
  return (level) => HEIGHT - PADDING - ((level - low) / (high - low)) * (HEIGHT - 2 * PADDING);
}

/** Returns the step whose state a frame shows or follows, at most the last one. */
export function stepAt(
  frame: number,
  nLevels: number,
  game: Pick<TaughtGame, "frames_per_step">,
): number {
  return Math.min(stepOf(frame, game), nLevels - 1);
}

function percentOf(frame: number, last: number): string {
  return `${(frame / Math.max(last, 1)) * 100}%`;
}
