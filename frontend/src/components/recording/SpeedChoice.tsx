import { Trans } from "@lingui/react/macro";
import { useSyncExternalStore } from "react";

import { type Playback, SPEEDS } from "@/lib/game/playback";

import styles from "./SpeedChoice.module.css";

interface SpeedChoiceProps {
  playback: Playback;
  /** Called when another speed is chosen. */
  onChoose?: (speed: number) => void;
}

/** A menu of the speeds at which a recording can be played. */
export function SpeedChoice({ playback, onChoose }: SpeedChoiceProps) {
  const { speed } = useSyncExternalStore(playback.subscribe, playback.snapshot);
  return (
    <label>
      <span className="visually-hidden">
        <Trans>Speed</Trans>
      </span>
      <select
        className={styles.speed}
        value={speed}
        onChange={(event) => {
          const chosen = Number(event.currentTarget.value);
          playback.setSpeed(chosen);
          onChoose?.(chosen);
        }}
      >
        {SPEEDS.map((one) => (
          <option key={one} value={one}>
            {one}×
          </option>
        ))}
      </select>
    </label>
  );
}
