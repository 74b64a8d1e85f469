import { useCallback, useEffect, useRef, useState } from "react";

import { messageOf } from "@/api/client";
import type { Behaviour } from "@/api/types";
import { GameCanvas } from "@/components/game/GameCanvas";
import { Checklist } from "@/features/play/hud/Checklist";
import { Clock, type ClockHandle } from "@/features/play/hud/Clock";
import { LatencyDisplay } from "@/features/play/hud/LatencyDisplay";
import { PaceControls } from "@/features/play/hud/PaceControls";
import { Score } from "@/features/play/hud/Score";
import { Tip } from "@/features/play/hud/Tip";
import { Toggles } from "@/features/play/hud/Toggles";
import { speedBeside, steers, type Wish } from "@/features/play/input/intents";
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
import { type PlayedGame, useGame } from "@/features/play/stream/use-game";
import { useFittingScreenSize } from "@/lib/game/use-screen-size";

import styles from "./PlayPage.module.css";

/** Header, path and margins take this much of the window's height. */
const CHROME_PX = 250;
const MIN_HEIGHT_PX = 210;
function stageHeight(windowHeight: number): number {
  if (document.fullscreenElement) return windowHeight;
  return Math.max(windowHeight - CHROME_PX, MIN_HEIGHT_PX);
}

/** Plays games of a behaviour. */
export function PlayPage({ behaviour }: { behaviour: Behaviour }) {
  const clock = useRef<ClockHandle>(null);
  const endCard = useRef<EndCardHandle>(null);
  const stage = useRef<HTMLDivElement>(null);
  const { screen, frames, setPainter } = useScreen(clock);
  const game = useGame(behaviour.id, screen);
  const size = useFittingScreenSize(stage, stageHeight);
  const [held] = useState(() => new HeldKeys());
  const [choosesKeys, setChoosesKeys] = useState(false);
  const [showsLatency] = useSetting(SHOW_LATENCY);
  const { target, ghost, hasGhost } = useMarks(behaviour);
  const { state, stream, start } = game;
  const phase = state?.phase;

  const onWish = useRef<(wish: Wish) => void>(() => undefined);
  useEffect(() => {
    onWish.current = (wish) => {
      if (wish === "fullscreen") toggleFullscreen(stage.current);
      else if (wish === "start") start();
      else if (!stream || phase === "ended" || !fulfil(wish, stream)) endCard.current?.wish(wish);
    };
  }, [stream, phase, start]);
  useKeys(stream, held, onWish);
  useGamepad(stream, held, onWish);
  useSounds(stream, frames);
  usePauseWhenHidden(game);
  // Keys must reach the game, not the button that was pressed last.
  const focusStage = useCallback(() => stage.current?.focus({ preventScroll: true }), []);
  useEffect(() => {
    if (phase === "countdown") focusStage();
    if (phase === "ended") held.releaseAll();
  }, [phase, held, focusStage]);

  return (
    <div className={styles.page}>
      <div>
        <div
          ref={stage}
          className={styles.stage}
          role="application"
          aria-label="Game. Arrow keys steer, space fires, Escape pauses."
          // The game takes keys, so it has to take the focus.
          // eslint-disable-next-line jsx-a11y/no-noninteractive-tabindex
          tabIndex={0}
        >
          <GameCanvas size={size} label="Game screen" onPainter={setPainter} />
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
            onGoOn={() => stream?.command("go_on")}
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
              onRewind={() => state.ended && game.goOnFrom(state.ended)}
            />
          )}
        </div>
        <TouchPad
          onHold={(name, bit, atMs) => {
            if (held.hold(name, bit)) stream?.hold(held.bits, atMs);
          }}
          onRelease={(name) => {
            if (held.release(name)) stream?.hold(held.bits);
          }}
        />
      </div>
      <aside className={styles.side} aria-label="The game so far">
        <Clock handle={clock} />
        <Score hits={state?.hits ?? []} behaviour={behaviour} />
        {state && stream && (
          <PaceControls
            state={state}
            onPause={() => stream.command("pause")}
            onGoOn={() => stream.command("go_on")}
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
        <Checklist behaviour={behaviour} />
        <KeyHelp />
        <Toggles
          hasTarget={behaviour.target !== null}
          hasGhost={hasGhost}
          marks={{ target, ghost }}
          onChooseKeys={() => {
            stream?.command("pause");
            setChoosesKeys(true);
          }}
          onFullscreen={() => toggleFullscreen(stage.current)}
        />
        <Tip behaviour={behaviour} />
      </aside>
      {choosesKeys && <KeysDialog onClose={() => setChoosesKeys(false)} />}
    </div>
  );
}

const SWITCHES = {
  latency: SHOW_LATENCY,
  targets: SHOW_TARGETS,
  ghost: SHOW_GHOST,
  sound: SOUND,
} as const;

/** Does what a press asks of the game; returns whether it was meant for it. */
function fulfil(wish: Wish, stream: GameStream): boolean {
  switch (wish) {
    case "pause":
    case "go_on":
      stream.command(wish);
      return true;
    case "step":
      stream.step();
      return true;
    case "rewind":
      stream.rewind();
      return true;
    case "slower":
    case "faster":
      stream.setSpeed(speedBeside(stream.snapshot().speed, wish));
      return true;
    case "latency":
    case "targets":
    case "ghost":
    case "sound":
      writeSetting(SWITCHES[wish], !readSetting(SWITCHES[wish]));
      return true;
    default:
      return false;
  }
}

function toggleFullscreen(stage: HTMLElement | null): void {
  const changed = document.fullscreenElement
    ? document.exitFullscreen()
    : stage?.requestFullscreen();
  // A browser may refuse it; the game goes on as it is.
  changed?.catch(() => undefined);
}

/** A game that can't be seen stands still. */
function usePauseWhenHidden({ stream }: PlayedGame): void {
  useEffect(() => {
    if (!stream) return undefined;
    const pause = () => {
      if (document.hidden && steers(stream.snapshot().phase)) stream.command("pause");
    };
    document.addEventListener("visibilitychange", pause);
    return () => document.removeEventListener("visibilitychange", pause);
  }, [stream]);
}
