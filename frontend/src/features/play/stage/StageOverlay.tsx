import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { Behaviour } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { ItemGrid } from "@/components/game/ItemGrid";
import type { GameState } from "@/features/play/stream/game-state";

import { keyName } from "@/features/play/input/keys";
import { useGame } from "@/games/game";
import { wordsOf } from "@/games/words";
import { seconds } from "@/lib/format";

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
  const game = useGame();
  const [rule] = game.end_rules;
  const ending = rule && (wordsOf(game).rules()[rule.name] ?? rule.title);
  const { state, target, starting, error, onStart, onResume, onStep, onTakeBack } = props;
  if (!state || state.phase === "gone") {
    const gone = state?.phase === "gone";
    return (
      <Overlay opaque>
        {!gone && <ItemGrid target={target} scale={2} label="" />}
        <span className={styles.big}>
          {gone
            ? t`This game is over`
            : t`${game.title}: up to ${seconds((game.max_steps * game.frames_per_step) / game.frame_rate_hz, 0)}`}
        </span>
        {!gone && ending !== undefined && (
          <p>
            <Trans>It ends earlier {ending}.</Trans>
          </p>
        )}
        <p>
          {error ??
            (gone
              ? t`It was idle for a while, so it ended. What you played is kept.`
              : t`Everything you do is recorded. Play well, or badly on purpose: both are useful.`)}
        </p>
        <Button kind="primary" large disabled={starting} onClick={onStart}>
          {starting ? t`Starting…` : error ? t`Try again` : t`Start game`}{" "}
          {!starting && <kbd aria-hidden="true">{keyName("Space")}</kbd>}
        </Button>
      </Overlay>
    );
  }
  switch (state.phase) {
    case "connecting":
      return (
        <Overlay opaque>
          <p role="status">
            <Trans>Starting…</Trans>
          </p>
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
          <span className={styles.big}>
            <Trans>Paused</Trans>
          </span>
          <p>{state.why}</p>
          <div className={styles.actions}>
            <Button kind="primary" large onClick={onResume}>
              <Trans>Resume</Trans>
            </Button>
            <Button large onClick={onStep}>
              <Trans>
                One frame <kbd>.</kbd>
              </Trans>
            </Button>
          </div>
        </Overlay>
      );
    case "stepping":
      return (
        <p className={styles.bottomLine} role="status">
          <Trans>
            Frame by frame: <kbd>.</kbd> plays one, <kbd>Enter</kbd> resumes
          </Trans>
        </p>
      );
    case "rewinding":
      return (
        <p className={styles.bottomLine} role="status">
          <Trans>Rewinding. Release to play on from here; both versions are kept.</Trans>
        </p>
      );
    case "lost":
      return (
        <Overlay>
          <span className={styles.big} role="alert">
            <Trans>Connection lost</Trans>
          </span>
          <p>
            <Trans>Your game is saved. It continues as soon as the server answers again.</Trans>
          </p>
        </Overlay>
      );
    case "full":
      return (
        <Overlay>
          <span className={styles.big} role="status">
            <Trans>All places are taken</Trans>
          </span>
          <p>
            <Trans>
              Too many games are being played. Stay on this page: yours continues as soon as one of
              them ends.
            </Trans>
          </p>
        </Overlay>
      );
    case "elsewhere":
      return (
        <Overlay>
          <span className={styles.big} role="alert">
            <Trans>This game is open in another tab now</Trans>
          </span>
          <p>
            <Trans>A game can be played in one tab at a time, the newest.</Trans>
          </p>
          <Button kind="primary" large onClick={onTakeBack}>
            <Trans>Play here</Trans>
          </Button>
        </Overlay>
      );
    case "refused":
      return (
        <Overlay>
          <span className={styles.big} role="alert">
            <Trans>This browser is no longer signed in</Trans>
          </span>
          <p>
            <Trans>
              Open the address that Tril printed when it started, then come back to continue.
            </Trans>
          </p>
        </Overlay>
      );
    case "playing":
    case "ended":
      return null;
  }
}
