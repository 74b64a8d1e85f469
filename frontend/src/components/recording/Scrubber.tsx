import { t } from "@lingui/core/macro";
import { memo, useSyncExternalStore } from "react";

import type { TaughtGame } from "@/api/types";
import { useGame } from "@/games/game";
import { seconds } from "@/lib/format";
import { cellName } from "@/lib/game/items";
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
  /** Omitted where the slider is of several recordings. */
  hits?: readonly Hit[] | undefined;
}

/** A slider over the frames, with marks at the hits. */
export function Scrubber({ playback, last, hits }: ScrubberProps) {
  const game = useGame();
  const { frame } = useSyncExternalStore(playback.subscribe, playback.snapshot);
  return (
    <div className={styles.scrubber}>
      {hits && game.items && <HitMarks hits={hits} last={last} />}
      <input
        type="range"
        className={styles.range}
        aria-label={t`Position in the recording`}
        aria-valuetext={t`${seconds(frame / game.frame_rate_hz)} of ${seconds(last / game.frame_rate_hz)}`}
        min={0}
        max={last}
        value={frame}
        onChange={(event) => playback.seek(event.currentTarget.valueAsNumber)}
      />
    </div>
  );
}

/** Bars for hits and crosses for strays, distinguishable without colour. */
const BAR = "M0 0V10";
const CROSS = "M-3 2 3 8M3 2-3 8";

const HitMarks = memo(function HitMarks({ hits, last }: { hits: readonly Hit[]; last: number }) {
  const game = useGame();
  return (
    <svg
      className={`${styles.plot ?? ""} ${styles.marks ?? ""}`}
      role="img"
      aria-label={
        hits.length === 0
          ? t`No hits`
          : t`Hits: ${hits.map((hit) => describeHit(hit, game)).join("; ")}`
      }
    >
      {hits.map((hit) => (
        <svg
          key={`${hit.frame}-${hit.row}-${hit.column}`}
          x={`${(hit.frame / Math.max(last, 1)) * 100}%`}
          overflow="visible"
        >
          <path className={markClass(hit)} d={hit.on_target === false ? CROSS : BAR}>
            <title>{describeHit(hit, game)}</title>
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

/** Describes a hit: "stray, row 3, column 4 at 0.3 s". */
export function describeHit(hit: Hit, game: Pick<TaughtGame, "frame_rate_hz">): string {
  const cell = cellName([hit.row, hit.column]);
  const time = seconds(hit.frame / game.frame_rate_hz);
  return hit.on_target === false ? t`stray, ${cell} at ${time}` : t`${cell} at ${time}`;
}
