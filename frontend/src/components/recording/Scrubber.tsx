import { memo, useSyncExternalStore } from "react";

import { FRAME_RATE_HZ, FRAMES_PER_STEP, measured, seconds } from "@/lib/format";
import { cellName } from "@/lib/game/aliens";
import type { Playback } from "@/lib/game/playback";

import styles from "./Scrubber.module.css";

interface Hit {
  readonly row: number;
  readonly column: number;
  readonly frame: number;
  readonly on_target: boolean | null;
}

interface ScrubberProps {
  playback: Playback;
  last: number;
  hits: readonly Hit[];
  /** R of each observation, one per step; plotted below on the same axis. */
  rewards?: readonly number[] | undefined;
}

/** A slider over the frames, with marks at the hits and R plotted below. */
export function Scrubber({ playback, last, hits, rewards }: ScrubberProps) {
  const { frame } = useSyncExternalStore(playback.subscribe, playback.snapshot);
  return (
    <div className={styles.scrubber}>
      <HitMarks hits={hits} last={last} />
      <input
        type="range"
        className={styles.range}
        aria-label="Position in the recording"
        aria-valuetext={`${seconds(frame / FRAME_RATE_HZ)} of ${seconds(last / FRAME_RATE_HZ)}`}
        min={0}
        max={last}
        value={frame}
        onChange={(event) => playback.seek(event.currentTarget.valueAsNumber)}
      />
      {rewards && rewards.length > 1 && <RewardPlot rewards={rewards} frame={frame} last={last} />}
    </div>
  );
}

/** Bars for hits and crosses for strays, distinguishable without colour. */
const BAR = "M0 0V10";
const CROSS = "M-3 2 3 8M3 2-3 8";

const HitMarks = memo(function HitMarks({ hits, last }: { hits: readonly Hit[]; last: number }) {
  return (
    <svg
      className={`${styles.plot ?? ""} ${styles.marks ?? ""}`}
      role="img"
      aria-label={hits.length === 0 ? "No hits" : `Hits: ${hits.map(describeHit).join("; ")}`}
    >
      {hits.map((hit) => (
        <svg
          key={`${hit.frame}-${hit.row}-${hit.column}`}
          x={`${(hit.frame / Math.max(last, 1)) * 100}%`}
          overflow="visible"
        >
          <path className={markClass(hit)} d={hit.on_target === false ? CROSS : BAR}>
            <title>{describeHit(hit)}</title>
          </path>
        </svg>
      ))}
    </svg>
  );
});

function markClass({ on_target: onTarget }: Hit): string | undefined {
  if (onTarget === null) return styles.hit;
  return onTarget ? styles.onTarget : styles.offTarget;
}

function describeHit(hit: Hit): string {
  const what = hit.on_target === false ? "stray, " : "";
  return `${what}${cellName([hit.row, hit.column])} at ${seconds(hit.frame / FRAME_RATE_HZ)}`;
}

const HEIGHT = 56;

function RewardPlot({
  rewards,
  frame,
  last,
}: {
  rewards: readonly number[];
  frame: number;
  last: number;
}) {
  const step = Math.min(Math.floor(frame / FRAMES_PER_STEP), rewards.length - 1);
  return (
    <>
      <svg
        className={styles.plot}
        viewBox={`0 0 ${Math.max(last, 1)} ${HEIGHT}`}
        height={HEIGHT}
        preserveAspectRatio="none"
        role="img"
        aria-label="R over time"
      >
        <RewardLine rewards={rewards} last={last} />
        <line className={styles.cursor} x1={frame} x2={frame} y1={0} y2={HEIGHT} />
      </svg>
      <div className={styles.legend}>
        <span>
          R of the reward model, {measured(Math.min(...rewards))} to{" "}
          {measured(Math.max(...rewards))}
        </span>
        <span>
          {measured(rewards[step] ?? NaN)} at step {step}
        </span>
      </div>
    </>
  );
}

const RewardLine = memo(function RewardLine({
  rewards,
  last,
}: {
  rewards: readonly number[];
  last: number;
}) {
  const low = Math.min(...rewards);
  const high = Math.max(...rewards);
  const y = (value: number) => HEIGHT - 2 - ((value - low) / (high - low || 1)) * (HEIGHT - 4);
  const points = rewards.map(
    (value, step) => `${Math.min(step * FRAMES_PER_STEP, last)} ${y(value).toFixed(2)}`,
  );
  return (
    <>
      {low < 0 && high > 0 && <line className={styles.zero} x1={0} x2={last} y1={y(0)} y2={y(0)} />}
      <path className={styles.line} d={`M${points.join("L")}`} />
    </>
  );
});
