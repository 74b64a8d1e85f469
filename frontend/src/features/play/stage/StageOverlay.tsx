import type { Behaviour } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { AlienGrid } from "@/components/game/AlienGrid";
import type { GameState } from "@/features/play/stream/game-stream";

import { Overlay } from "./Overlay";
import styles from "./Overlay.module.css";

interface StageOverlayProps {
  state: GameState | null;
  target: Behaviour["target"];
  starting: boolean;
  error: string | null;
  onStart: () => void;
  onGoOn: () => void;
  onStep: () => void;
  onTakeBack: () => void;
}

/** What lies over the screen while nobody is playing on it. The end has its own card. */
export function StageOverlay(props: StageOverlayProps) {
  const { state, target, starting, error, onStart, onGoOn, onStep, onTakeBack } = props;
  if (!state || state.phase === "gone") {
    const gone = state?.phase === "gone";
    return (
      <Overlay opaque>
        {!gone && <AlienGrid target={target} scale={2} label="" />}
        <span className={styles.big}>
          {gone ? "This game is over" : "Twenty seconds, one life"}
        </span>
        <p>
          {error ??
            (gone
              ? "Nobody played on for a while, so it ended. What was played of it is kept."
              : "Everything you do is recorded. Play well, or badly on purpose: both teach.")}
        </p>
        <Button kind="primary" large disabled={starting} onClick={onStart}>
          {starting ? "Starting…" : error ? "Try again" : "Start game"}
        </Button>
      </Overlay>
    );
  }
  switch (state.phase) {
    case "connecting":
      return (
        <Overlay opaque>
          <p role="status">Starting…</p>
        </Overlay>
      );
    case "countdown":
      return (
        <Overlay className={styles.count}>
          <strong role="timer" aria-live="assertive">
            {state.seconds}
          </strong>
        </Overlay>
      );
    case "paused":
      return (
        <Overlay>
          <span className={styles.big}>Paused</span>
          <p>{state.why}</p>
          <div className={styles.actions}>
            <Button kind="primary" large onClick={onGoOn}>
              Go on
            </Button>
            <Button large onClick={onStep}>
              One frame <kbd>.</kbd>
            </Button>
          </div>
        </Overlay>
      );
    case "stepping":
      return (
        <p className={styles.bottomLine} role="status">
          Frame by frame: <kbd>.</kbd> plays one, <kbd>Enter</kbd> goes on
        </p>
      );
    case "rewinding":
      return (
        <p className={styles.bottomLine} role="status">
          Running back. Let go to play on from here; both ways are kept.
        </p>
      );
    case "lost":
      return (
        <Overlay>
          <span className={styles.big} role="alert">
            The connection broke
          </span>
          <p>Your game is saved and waits. It goes on as soon as the server answers again.</p>
        </Overlay>
      );
    case "full":
      return (
        <Overlay>
          <span className={styles.big} role="status">
            All places are taken
          </span>
          <p>
            Too many games are being played. Stay on this page: yours goes on as soon as one of them
            ends.
          </p>
        </Overlay>
      );
    case "elsewhere":
      return (
        <Overlay>
          <span className={styles.big} role="alert">
            Another tab plays this game now
          </span>
          <p>Each game is played in one place: the newest tab has it.</p>
          <Button kind="primary" large onClick={onTakeBack}>
            Play here
          </Button>
        </Overlay>
      );
    case "refused":
      return (
        <Overlay>
          <span className={styles.big} role="alert">
            This browser isn&rsquo;t let in any more
          </span>
          <p>Open the address that Tril printed when it started, then come back to go on.</p>
        </Overlay>
      );
    case "playing":
    case "ended":
      return null;
  }
}
