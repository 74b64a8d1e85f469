import type { Behaviour } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { AlienGrid } from "@/components/game/AlienGrid";
import type { GameState } from "@/features/play/stream/game-state";

import { Overlay } from "./Overlay";
import styles from "./Overlay.module.css";

interface StageOverlayProps {
  state: GameState | null;
  target: Behaviour["target"];
  starting: boolean;
  error: string | null;
  onStart: () => void;
  onResume: () => void;
  onStep: () => void;
  onTakeBack: () => void;
}

/** The overlay on the screen while the game is not being played; for the end see EndCard. */
export function StageOverlay(props: StageOverlayProps) {
  const { state, target, starting, error, onStart, onResume, onStep, onTakeBack } = props;
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
              ? "It was idle for a while, so it ended. What you played is kept."
              : "Everything you do is recorded. Play well, or badly on purpose: both are useful.")}
        </p>
        <Button kind="primary" large disabled={starting} onClick={onStart}>
          {starting ? "Starting…" : error ? "Try again" : "Start game"}{" "}
          {!starting && <kbd aria-hidden="true">Space</kbd>}
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
            <Button kind="primary" large onClick={onResume}>
              Resume
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
          Frame by frame: <kbd>.</kbd> plays one, <kbd>Enter</kbd> resumes
        </p>
      );
    case "rewinding":
      return (
        <p className={styles.bottomLine} role="status">
          Rewinding. Release to play on from here; both versions are kept.
        </p>
      );
    case "lost":
      return (
        <Overlay>
          <span className={styles.big} role="alert">
            Connection lost
          </span>
          <p>Your game is saved. It continues as soon as the server answers again.</p>
        </Overlay>
      );
    case "full":
      return (
        <Overlay>
          <span className={styles.big} role="status">
            All places are taken
          </span>
          <p>
            Too many games are being played. Stay on this page: yours continues as soon as one of
            them ends.
          </p>
        </Overlay>
      );
    case "elsewhere":
      return (
        <Overlay>
          <span className={styles.big} role="alert">
            This game is open in another tab now
          </span>
          <p>A game can be played in one tab at a time, the newest.</p>
          <Button kind="primary" large onClick={onTakeBack}>
            Play here
          </Button>
        </Overlay>
      );
    case "refused":
      return (
        <Overlay>
          <span className={styles.big} role="alert">
            This browser is no longer signed in
          </span>
          <p>Open the address that Tril printed when it started, then come back to continue.</p>
        </Overlay>
      );
    case "playing":
    case "ended":
      return null;
  }
}
