import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { type RefObject, useImperativeHandle, useRef } from "react";

import { fixed, FRAME_RATE_HZ, FRAMES_PER_STEP, MAX_STEPS } from "@/lib/format";

import styles from "./Clock.module.css";

/** Updates the clock without rendering: it changes 60 times a second. */
export interface ClockHandle {
  show: (frame: number, maxFrames: number) => void;
}

/** The time left of the game's 300 steps. */
export function Clock({
  handle,
  also,
}: {
  handle: RefObject<ClockHandle | null>;
  /** Another element that shows the seconds left. */
  also?: RefObject<HTMLElement | null>;
}) {
  const left = useRef<HTMLSpanElement>(null);
  const step = useRef<HTMLSpanElement>(null);
  const bar = useRef<HTMLElement>(null);
  useImperativeHandle(handle, () => ({
    show: (frame, maxFrames) => {
      if (!left.current || !step.current || !bar.current) return;
      const seconds = fixed((maxFrames - frame) / FRAME_RATE_HZ, 1);
      left.current.textContent = seconds;
      if (also?.current) also.current.textContent = seconds;
      step.current.textContent = stepWords(frame);
      bar.current.style.transform = `scaleX(${1 - frame / maxFrames})`;
    },
  }));
  return (
    <div className={styles.time}>
      <div className={styles.timeWords}>
        <span role="timer" aria-label={t`Time left`}>
          <Trans>
            <span className={styles.timeLeft} ref={left}>
              {fixed((MAX_STEPS * FRAMES_PER_STEP) / FRAME_RATE_HZ, 1)}
            </span>{" "}
            s left
          </Trans>
        </span>
        <span className={styles.step} ref={step}>
          {stepWords(0)}
        </span>
      </div>
      <div className={styles.bar}>
        <i ref={bar} />
      </div>
    </div>
  );
}

/** Counts a step that has begun, as a recording's number of steps does. */
function stepWords(frame: number): string {
  return t`step ${Math.ceil(frame / FRAMES_PER_STEP)} of ${MAX_STEPS}`;
}
