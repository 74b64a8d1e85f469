import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import type { RefObject } from "react";

import { Button } from "@/components/controls/Button";
import { Clock, type ClockHandle } from "@/features/play/hud/Clock";

import { keyName } from "@/features/play/input/keys";
import { percent } from "@/lib/format";

import { type Choice, N_STARTS } from "./choice";
import styles from "./Transport.module.css";
import { WATCH_SPEEDS } from "./watch-keys";
import type { WatchState } from "./watch-stream";

interface TransportProps {
  state: WatchState | null;
  choice: Choice;
  clock: RefObject<ClockHandle | null>;
  onToggle: () => void;
  onStep: () => void;
  onSpeed: (percent: number) => void;
  onRestart: () => void;
  onNext: () => void;
  /** Called with an evaluation start; null for a new one. */
  onStart: (start: number | null) => void;
}

/** Pause, single steps, slow motion, and where the games begin. */
export function Transport(props: TransportProps) {
  const { state, choice } = props;
  const isRunning = state?.phase === "playing" || state?.phase === "waiting";
  const isPaused = state?.phase === "paused";
  return (
    <div className={styles.transport} role="group" aria-label={t`Playback`}>
      <div className={styles.row}>
        <Button
          kind="primary"
          icon={isRunning ? "pause" : "play"}
          disabled={!isRunning && !isPaused}
          onClick={props.onToggle}
        >
          {isRunning ? t`Pause` : t({ message: "Play", context: "playback" })}{" "}
          <kbd>{keyName("Space")}</kbd>
        </Button>
        <Button icon="stepOn" disabled={!isPaused && !isRunning} onClick={props.onStep}>
          <Trans>
            One step <kbd>.</kbd>
          </Trans>
        </Button>
        <div className={styles.speeds} role="group" aria-label={t`Speed`}>
          {WATCH_SPEEDS.map((choice) => (
            <Button
              key={choice}
              kind="quiet"
              aria-pressed={choice === state?.speed}
              onClick={() => props.onSpeed(choice)}
            >
              {percent(choice / 100, 0)}
            </Button>
          ))}
        </div>
      </div>
      <div className={styles.row}>
        <Button icon="restart" onClick={props.onRestart}>
          <Trans>
            Restart <kbd>R</kbd>
          </Trans>
        </Button>
        <select
          aria-label={t`Start`}
          value={choice.start ?? "new"}
          onChange={(event) => {
            const { value } = event.currentTarget;
            props.onStart(value === "new" ? null : Number(value));
          }}
        >
          <option value="new">
            <Trans>New start, with an opening</Trans>
          </option>
          {Array.from({ length: N_STARTS }, (_, start) => (
            <option key={start} value={start}>
              <Trans>Evaluation start {start}</Trans>
            </option>
          ))}
        </select>
        <Button icon="arrowRight" onClick={props.onNext}>
          <Trans>
            Next start <kbd>N</kbd>
          </Trans>
        </Button>
      </div>
      <div className={styles.clock}>
        <Clock handle={props.clock} />
      </div>
    </div>
  );
}
