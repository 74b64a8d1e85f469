import { Fragment, useCallback, useEffect, useMemo, useRef, useState } from "react";
import { Link } from "react-router";

import { Checklist } from "./Checklist";
import { KEYS, SHOW_LATENCY } from "./choices";
import { speedBeside, steers, type Wish, wishOf } from "./controls";
import { EndCard, type EndCardHandle } from "./EndCard";
import type { GameScreen, GameStream } from "./game-stream";
import { Clock, type ClockHandle, Score } from "./Hud";
import { KeysDialog } from "./KeysDialog";
import { LatencyDisplay } from "./LatencyDisplay";
import { StageOverlay } from "./Overlays";
import { PaceControls } from "./PaceControls";
import styles from "./PlayPage.module.css";
import { TouchPad } from "./TouchPad";
import { type PlayedGame, useGame } from "./use-game";
import { useGamepad } from "./use-gamepad";

import { messageOf } from "@/api/client";
import type { Behaviour } from "@/api/types";
import { Button } from "@/components/Button";
import { GameCanvas } from "@/components/GameCanvas";
import { bitOf, type Control, controlOf, HeldKeys, isGameKey, keyName } from "@/lib/keys";
import type { Palette, ScreenPainter } from "@/lib/screen";
import { readChoice, useChoice, writeChoice } from "@/lib/stored";
import { useFittingScreenSize } from "@/lib/use-screen-size";

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
  const { screen, setPainter } = useScreen(clock);
  const game = useGame(behaviour.id, screen);
  const size = useFittingScreenSize(stage, stageHeight);
  const [held] = useState(() => new HeldKeys());
  const [choosesKeys, setChoosesKeys] = useState(false);
  const [showsLatency, setShowsLatency] = useChoice(SHOW_LATENCY);
  const { state, stream } = game;
  const phase = state?.phase;

  const onWish = useRef<(wish: Wish) => void>(() => undefined);
  useEffect(() => {
    onWish.current = (wish) => {
      if (wish === "fullscreen") toggleFullscreen(stage.current);
      else if (!stream || phase === "ended" || !fulfil(wish, stream)) endCard.current?.wish(wish);
    };
  }, [stream, phase]);
  useKeys(game, held, onWish);
  useGamepad(stream, held, onWish);
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
        <div className={styles.toggles}>
          <Button
            kind="quiet"
            onClick={() => {
              stream?.command("pause");
              setChoosesKeys(true);
            }}
          >
            Change the keys
          </Button>
          <Button
            kind="quiet"
            aria-pressed={showsLatency}
            onClick={() => setShowsLatency(!showsLatency)}
          >
            Latency <kbd>L</kbd>
          </Button>
          <Button kind="quiet" onClick={() => toggleFullscreen(stage.current)}>
            Fullscreen <kbd>F</kbd>
          </Button>
        </div>
        <Tip behaviour={behaviour} />
      </aside>
      {choosesKeys && <KeysDialog onClose={() => setChoosesKeys(false)} />}
    </div>
  );
}

/** The screen that frames are shown on: the canvas and the clock, past React. */
function useScreen(clock: React.RefObject<ClockHandle | null>) {
  const painter = useRef<ScreenPainter | null>(null);
  const palette = useRef<Palette | null>(null);
  const screen = useMemo<GameScreen>(
    () => ({
      setPalette: (colours) => {
        palette.current = colours;
        painter.current?.setPalette(colours);
      },
      show: (pixels, frame, maxFrames) => {
        painter.current?.draw(pixels);
        clock.current?.show(frame, maxFrames);
      },
    }),
    [clock],
  );
  const setPainter = useCallback((ready: ScreenPainter) => {
    painter.current = ready;
    if (palette.current) ready.setPalette(palette.current);
  }, []);
  return { screen, setPainter };
}

/** Passes keys on to the game, and what else they ask for to where it is done. */
function useKeys(
  { stream }: PlayedGame,
  held: HeldKeys,
  onWish: React.RefObject<(wish: Wish) => void>,
): void {
  useEffect(() => {
    if (!stream) return undefined;
    const down = (event: KeyboardEvent) => {
      if (event.ctrlKey || event.metaKey || event.altKey || isElsewhere(event.target)) return;
      const { phase, endedAt } = stream.snapshot();
      const keys = readChoice(KEYS);
      const wish = wishOf(event, phase, performance.now() - endedAt, keys);
      if (wish && !(isButton(event.target) && pressesButton(event.code))) {
        event.preventDefault();
        onWish.current(wish);
      } else if (steers(phase) && isGameKey(keys, event.code)) {
        event.preventDefault();
        if (held.hold(event.code, bitOf(keys, event.code))) {
          stream.hold(held.bits, event.timeStamp);
        }
      } else if (phase === "ended" && event.repeat && isGameKey(keys, event.code)) {
        // Still held from the game: it must neither scroll the page nor press a button.
        event.preventDefault();
      }
    };
    const up = (event: KeyboardEvent) => {
      if (controlOf(readChoice(KEYS), event.code) === "rewind") stream.release();
      if (held.release(event.code)) stream.hold(held.bits);
    };
    const letGo = () => {
      stream.release();
      if (held.releaseAll()) stream.hold(0);
    };
    window.addEventListener("keydown", down);
    window.addEventListener("keyup", up);
    window.addEventListener("blur", letGo);
    return () => {
      letGo();
      window.removeEventListener("keydown", down);
      window.removeEventListener("keyup", up);
      window.removeEventListener("blur", letGo);
    };
  }, [stream, held, onWish]);
}

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
      writeChoice(SHOW_LATENCY, !readChoice(SHOW_LATENCY));
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

/** Whether keys are meant for something else: a field, or an open dialog. */
function isElsewhere(target: EventTarget | null): boolean {
  if (document.querySelector("dialog[open]")) return true;
  return target instanceof HTMLElement && target.matches("input, textarea, select");
}

function isButton(target: EventTarget | null): boolean {
  return target instanceof HTMLElement && target.matches("button, a");
}

function pressesButton(code: string): boolean {
  return code === "Space" || code === "Enter" || code === "NumpadEnter";
}

function KeyHelp() {
  const [keys] = useChoice(KEYS);
  const names = (control: Control) =>
    keys[control].map((code) => (
      <Fragment key={code}>
        <kbd>{keyName(code)}</kbd>{" "}
      </Fragment>
    ));
  return (
    <dl className={styles.keys} aria-label="Keys">
      <dt>
        {names("left")}
        {names("right")}
      </dt>
      <dd>move</dd>
      <dt>{names("fire")}</dt>
      <dd>fire, may be held</dd>
      <dt>{names("rewind")}</dt>
      <dd>rewind while held</dd>
      <dt>{names("pause")}</dt>
      <dd>pause</dd>
      <dt>
        <kbd>.</kbd>
      </dt>
      <dd>frame by frame</dd>
    </dl>
  );
}

function Tip({ behaviour }: { behaviour: Behaviour }) {
  const { n_recordings: n, id } = behaviour;
  if (n < 2) {
    return (
      <p className={styles.tip}>
        Two recordings are the least that can be ranked; about a dozen, from perfect to hopeless,
        is what an agent learns well from.
      </p>
    );
  }
  return (
    <p className={styles.tip}>
      {n} recordings so far. <Link to={`/behaviours/${id}/rank`}>Put them in order</Link> whenever
      you like.
    </p>
  );
}
