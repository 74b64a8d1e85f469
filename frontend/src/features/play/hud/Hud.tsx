import { type RefObject, useImperativeHandle, useRef } from "react";

import type { Behaviour } from "@/api/types";
import { AlienGrid } from "@/components/game/AlienGrid";
import styles from "@/features/play/PlayPage.module.css";
import type { HitAt } from "@/features/play/stream/text-messages";
import { FRAME_RATE_HZ, FRAMES_PER_STEP, MAX_STEPS } from "@/lib/format";
import { gridState } from "@/lib/game/aliens";

/** Shows the time without React: it changes sixty times a second. */
export interface ClockHandle {
  show: (frame: number, maxFrames: number) => void;
}

/** Time left of the 300 steps. */
export function Clock({ handle }: { handle: RefObject<ClockHandle | null> }) {
  const left = useRef<HTMLSpanElement>(null);
  const step = useRef<HTMLSpanElement>(null);
  const bar = useRef<HTMLElement>(null);
  useImperativeHandle(handle, () => ({
    show: (frame, maxFrames) => {
      if (!left.current || !step.current || !bar.current) return;
      left.current.textContent = ((maxFrames - frame) / FRAME_RATE_HZ).toFixed(1);
      step.current.textContent = stepWords(frame);
      bar.current.style.transform = `scaleX(${1 - frame / maxFrames})`;
    },
  }));
  return (
    <div className={styles.time}>
      <div className={styles.timeWords}>
        <span role="timer" aria-label="Time left">
          <span className={styles.timeLeft} ref={left}>
            {(MAX_STEPS * FRAMES_PER_STEP) / FRAME_RATE_HZ}.0
          </span>{" "}
          s left
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

function stepWords(frame: number): string {
  return `step ${Math.floor(frame / FRAMES_PER_STEP)} of ${MAX_STEPS}`;
}

/** What was hit so far, on and off target. */
export function Score({ hits, behaviour }: { hits: readonly HitAt[]; behaviour: Behaviour }) {
  const cells = hits.map(({ row, column }) => [row, column] as const);
  const { hit, stray } = gridState(cells, behaviour.target);
  return (
    <div className={styles.score}>
      <AlienGrid hits={cells} target={behaviour.target} scale={2} />
      <dl>
        {behaviour.target ? (
          <>
            <div>
              <dt>Targets hit</dt>
              <dd>
                {hit.length} <small>of {behaviour.target.length}</small>
              </dd>
            </div>
            <div>
              <dt>Strays</dt>
              <dd>{stray.length}</dd>
            </div>
          </>
        ) : (
          <div>
            <dt>Aliens hit</dt>
            <dd>{hits.length}</dd>
          </div>
        )}
      </dl>
    </div>
  );
}
