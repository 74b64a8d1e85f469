import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { type RefObject, useImperativeHandle, useRef } from "react";

import type { TaughtGame } from "@/api/types";
import { useGame } from "@/games/game";
import { fixed } from "@/lib/format";

import styles from "./Clock.module.css";

/** Updates the clock without rendering: it changes 60 times a second. */
export interface ClockHandle {
  show: (frame: number, maxFrames: number) => void;
}

/** The time and the steps left of the game. */
export function Clock({
  handle,
  also,
}: {
  handle: RefObject<ClockHandle | null>;
  /** Another element that shows the seconds left. */
  also?: RefObject<HTMLElement | null>;
}) {
  const game = useGame();
  const left = useRef<HTMLSpanElement>(null);
  const step = useRef<HTMLSpanElement>(null);
  const bar = useRef<HTMLElement>(null);
  useImperativeHandle(handle, () => ({
    show: (frame, maxFrames) => {
      if (!left.current || !step.current || !bar.current) return;
      const seconds = fixed((maxFrames - frame) / game.frame_rate_hz, 1);
      left.current.textContent = seconds;
      if (also?.current) also.current.textContent = seconds;
      step.current.textContent = stepWords(frame, game);
      bar.current.style.transform = `scaleX(${1 - frame / maxFrames})`;
    },
  }));
  return (
    <div className={styles.time}>
      <div className={styles.timeWords}>
        <span role="timer" aria-label={t`Time left`}>
          <Trans>
            <span className={styles.timeLeft} ref={left}>
              {fixed((game.max_steps * game.frames_per_step) / game.frame_rate_hz, 1)}
            </span>{" "}
            s left
          </Trans>
        </span>
        <span className={styles.step} ref={step}>
          {stepWords(0, game)}
        </span>
      </div>
      <div className={styles.bar}>
        <i ref={bar} />
      </div>
    </div>
  );
}

/** Counts a step that has begun, as a recording's number of steps does. */
function stepWords(frame: number, game: TaughtGame): string {
  return t`step ${Math.ceil(frame / game.frames_per_step)} of ${game.max_steps}`;
}
