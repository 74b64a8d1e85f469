import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import { Button } from "@/components/controls/Button";
import { ControlKey } from "@/features/play/input/ControlKey";
import { steers } from "@/features/play/input/intents";
import type { GameState } from "@/features/play/stream/game-state";
import { SPEEDS } from "@/features/play/stream/text-messages";
import { useGame } from "@/games/game";
import { percent } from "@/lib/format";

import styles from "./PaceControls.module.css";

interface PaceControlsProps {
  state: GameState;
  onPause: () => void;
  onResume: () => void;
  onStep: () => void;
  onStop: () => void;
  onSpeed: (percent: number) => void;
  onRewind: () => void;
  onRelease: () => void;
}

/** Pause, single frames, rewind and slow motion. */
export function PaceControls(props: PaceControlsProps) {
  const { saves_states: canRewind } = useGame();
  const { phase, speed } = props.state;
  const isPaused = phase === "paused" || phase === "stepping";
  if (!steers(phase)) return null;
  return (
    <div className={styles.pace}>
      <div className={styles.stop}>
        {isPaused ? (
          <>
            <Button icon="play" onClick={props.onResume}>
              <Trans>Resume</Trans>
            </Button>
            <Button icon="stepOn" onClick={props.onStep}>
              <Trans>
                One frame <kbd>.</kbd>
              </Trans>
            </Button>
          </>
        ) : (
          <Button icon="pause" onClick={props.onPause}>
            <Trans>Pause</Trans>
          </Button>
        )}
        {canRewind && (
          <Button
            icon="undo"
            title={t`Hold to rewind; release to play on from there`}
            onPointerDown={(event) => {
              event.currentTarget.setPointerCapture(event.pointerId);
              props.onRewind();
            }}
            onLostPointerCapture={props.onRelease}
            onContextMenu={(event) => event.preventDefault()}
          >
            <Trans>Rewind</Trans> <ControlKey control="rewind" />
          </Button>
        )}
        <Button onClick={props.onStop}>
          <Trans>End the game here</Trans>
        </Button>
      </div>
      <div className={styles.speeds} role="group" aria-label={t`Speed`}>
        {SPEEDS.map((choice) => (
          <Button
            key={choice}
            kind="quiet"
            aria-pressed={choice === speed}
            onClick={() => props.onSpeed(choice)}
          >
            {percent(choice / 100, 0)}
          </Button>
        ))}
        <span className={styles.speedKeys}>
          <kbd>−</kbd> <kbd>+</kbd>
        </span>
      </div>
    </div>
  );
}
