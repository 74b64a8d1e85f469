import { t } from "@lingui/core/macro";
import { useCallback, useEffect, useRef, useState } from "react";

import { messageOf } from "@/api/client";
import type { Behaviour } from "@/api/types";
import { GameCanvas } from "@/components/game/GameCanvas";
import { Checklist } from "@/features/play/hud/Checklist";
import { Clock, type ClockHandle } from "@/features/play/hud/Clock";
import { LatencyDisplay } from "@/features/play/hud/LatencyDisplay";
import { PaceControls } from "@/features/play/hud/PaceControls";
import { Score } from "@/features/play/hud/Score";
import { StageHud } from "@/features/play/hud/StageHud";
import { Tip } from "@/features/play/hud/Tip";
import { Toggles } from "@/features/play/hud/Toggles";
import { Undecided } from "@/features/play/hud/Undecided";
import { speedBeside, steers, type Intent } from "@/features/play/input/intents";
import { KeyHelp } from "@/features/play/input/KeyHelp";
import { HeldKeys } from "@/features/play/input/keys";
import { KeysDialog } from "@/features/play/input/KeysDialog";
import { TouchPad } from "@/features/play/input/TouchPad";
import { useGamepad } from "@/features/play/input/use-gamepad";
import { useKeys } from "@/features/play/input/use-keys";
import { SHOW_GHOST, SHOW_LATENCY, SHOW_TARGETS, SOUND } from "@/features/play/settings/settings";
import { readSetting, useSetting, writeSetting } from "@/features/play/settings/stored";
import { useSounds } from "@/features/play/sound/use-sounds";
import { EndCard, type EndCardHandle } from "@/features/play/stage/EndCard";
import { MarksCanvas } from "@/features/play/stage/MarksCanvas";
import { StageOverlay } from "@/features/play/stage/StageOverlay";
import { useMarks } from "@/features/play/stage/use-marks";
import { useScreen } from "@/features/play/stage/use-screen";
import type { GameStream } from "@/features/play/stream/game-stream";
import { type PlayedGame, usePlayedGame } from "@/features/play/stream/use-played-game";
import { useGame } from "@/games/game";
import { useFittingScreenSize } from "@/lib/game/use-screen-size";

import styles from "./PlayPage.module.css";

/** Height of the header, the path and the margins. */
const CHROME_PX = 150;
const MIN_HEIGHT_PX = 210;
/** As in PlayPage.module.css: the stage fills the window. */
const LANDSCAPE_PHONE = "(pointer: coarse) and (orientation: landscape) and (max-height: 32rem)";

function stageHeight(windowHeight: number): number {
  if (document.fullscreenElement || matchMedia(LANDSCAPE_PHONE).matches) return windowHeight;
  return Math.max(windowHeight - CHROME_PX, MIN_HEIGHT_PX);
}

/** Plays games of a behaviour. */
export function PlayPage({ behaviour }: { behaviour: Behaviour }) {
  const clock = useRef<ClockHandle>(null);
  const endCard = useRef<EndCardHandle>(null);
  /** What fullscreen shows: the stage, the touch pad over it, and the state of the game. */
  const arena = useRef<HTMLDivElement>(null);
  const stage = useRef<HTMLDivElement>(null);
  const hudTime = useRef<HTMLSpanElement>(null);
  const { screen, frames, setPainter } = useScreen(clock);
  const taught = useGame();
  const game = usePlayedGame(behaviour.id, screen);
  const size = useFittingScreenSize(stage, stageHeight, taught);
  const [held] = useState(() => new HeldKeys());
  const [keysOpen, setKeysOpen] = useState(false);
  const [showsLatency] = useSetting(SHOW_LATENCY);
  const { target, ghost, hasGhost } = useMarks(behaviour);
  const { state, stream, start } = game;
  const phase = state?.phase;

  const onIntent = useRef<(intent: Intent) => void>(() => undefined);
  useEffect(() => {
    onIntent.current = (intent) => {
      if (intent === "fullscreen") toggleFullscreen(arena.current);
      else if (intent === "start") start();
      else if (!stream || phase === "ended" || !execute(intent, stream))
        endCard.current?.execute(intent);
    };
  }, [stream, phase, start]);
  useKeys(stream, held, onIntent);
  useGamepad(stream, held, onIntent);
  useSounds(stream, frames);
  usePauseWhenHidden(game);
  // Otherwise keys would go to the button that was pressed last.
  const focusStage = useCallback(() => stage.current?.focus({ preventScroll: true }), []);
  useEffect(() => {
    if (phase === "countdown") focusStage();
    if (phase === "countdown" && matchMedia(LANDSCAPE_PHONE).matches) {
      arena.current?.scrollIntoView();
    }
    if (phase === "ended") held.releaseAll();
  }, [phase, held, focusStage]);

  return (
    <div className={styles.page}>
      <div ref={arena} className={styles.arena}>
        <div
          ref={stage}
          className={styles.stage}
          role="application"
          aria-label={t`Game. Its keys are listed on this page.`}
          // Focusable, since the game takes keyboard input.
          // eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex
          tabIndex={0}
        >
          <GameCanvas size={size} label={t`Game screen`} onPainter={setPainter} />
          {stream && (target ?? ghost) && (
            <MarksCanvas
              size={size}
              stream={stream}
              frames={frames}
              target={target}
              ghost={ghost}
            />
          )}
          {stream && showsLatency && <LatencyDisplay stream={stream} />}
          <StageOverlay
            state={state}
            target={behaviour.target}
            starting={game.starting}
            error={game.error ? messageOf(game.error) : null}
            onStart={game.start}
            onResume={() => stream?.command("go_on")}
            onStep={() => {
              stream?.step();
              focusStage();
            }}
            onTakeBack={() => stream?.connect()}
          />
          {state?.ended && (
            <EndCard
              key={state.ended.recording_id}
              ended={state.ended}
              behaviour={behaviour}
              handle={endCard}
              starting={game.starting}
              onAgain={game.start}
              onRewind={() => state.ended && game.continueFrom(state.ended)}
            />
          )}
        </div>
        <StageHud time={hudTime} hits={state?.hits ?? []} behaviour={behaviour} />
        <TouchPad
          idle={!phase || !steers(phase)}
          onHold={(name, bits, atMs) => {
            if (held.hold(name, bits)) stream?.hold(held.bits, atMs);
          }}
          onRelease={(name) => {
            if (held.release(name)) stream?.hold(held.bits);
          }}
        />
      </div>
      <aside className={styles.side} aria-label={t`Game status`}>
        <Clock handle={clock} also={hudTime} />
        <Score hits={state?.hits ?? []} behaviour={behaviour} />
        {state && stream && (
          <PaceControls
            state={state}
            onPause={() => stream.command("pause")}
            onResume={() => stream.command("go_on")}
            onStep={() => {
              stream.step();
              focusStage();
            }}
            onStop={() => stream.command("stop")}
            onRewind={() => stream.rewind()}
            onRelease={() => {
              stream.release();
              focusStage();
            }}
            onSpeed={(percent) => {
              stream.setSpeed(percent);
              focusStage();
            }}
          />
        )}
        <Undecided behaviour={behaviour} besides={state?.ended?.recording_id} />
        {taught.has_player && <Checklist behaviour={behaviour} />}
        <KeyHelp />
        <Toggles
          hasTarget={behaviour.target !== null}
          hasGhost={hasGhost}
          marks={{ target, ghost }}
          onChooseKeys={() => {
            stream?.command("pause");
            setKeysOpen(true);
          }}
          onFullscreen={() => toggleFullscreen(arena.current)}
        />
        <Tip behaviour={behaviour} />
      </aside>
      {keysOpen && <KeysDialog onClose={() => setKeysOpen(false)} />}
    </div>
  );
}

const SWITCHES = {
  latency: SHOW_LATENCY,
  targets: SHOW_TARGETS,
  ghost: SHOW_GHOST,
  sound: SOUND,
} as const;

/** Executes an intent that concerns the game; returns false for any other. */
function execute(intent: Intent, stream: GameStream): boolean {
  switch (intent) {
    case "pause":
    case "go_on":
      stream.command(intent);
      return true;
    case "step":
      stream.step();
      return true;
    case "rewind":
      stream.rewind();
      return true;
    case "slower":
    case "faster":
      stream.setSpeed(speedBeside(stream.snapshot().speed, intent));
      return true;
    case "latency":
    case "targets":
    case "ghost":
    case "sound":
      writeSetting(SWITCHES[intent], !readSetting(SWITCHES[intent]));
      return true;
    default:
      return false;
  }
}

function toggleFullscreen(arena: HTMLElement | null): void {
  const changed = document.fullscreenElement
    ? document.exitFullscreen()
    : arena?.requestFullscreen();
  // The browser may refuse; the game continues as it is.
  changed?.catch(() => undefined);
}

/** Pauses the game when its tab is hidden. */
function usePauseWhenHidden({ stream }: PlayedGame): void {
  useEffect(() => {
    if (!stream) return undefined;
    const pause = () => {
      const { phase } = stream.snapshot();
      if (document.hidden && steers(phase) && phase !== "paused") stream.command("pause");
    };
    document.addEventListener("visibilitychange", pause);
    return () => document.removeEventListener("visibilitychange", pause);
  }, [stream]);
}
