import { type RefObject, useEffect } from "react";

import { readSetting } from "@/features/play/settings/stored";
import type { GameStream } from "@/features/play/stream/game-stream";
import { useGame } from "@/games/game";
import { ofSigns, placeOf, type Pressed } from "@/lib/browser/pressed-keys";

import { dialogIsOpen } from "./dialogs";
import { type Intent, intentOf, SinceEnd, steers } from "./intents";
import { bitOf, controlOf, type HeldKeys, isGameKey, keysSetting } from "./keys";

const NO_GAME = { phase: null, endedAt: 0 };

/** After these the browser may never tell of keys that are let go. */
const LOSSES = [
  "blur",
  "visibilitychange",
  "pagehide",
  "contextmenu",
  "fullscreenchange",
  "pointerlockchange",
] as const;

/**
 * Sends steering keys to the game and reports every other intent.
 *
 * @param stream Null before the first game.
 */
export function useKeys(
  stream: GameStream | null,
  held: HeldKeys,
  onIntent: RefObject<(intent: Intent) => void>,
): void {
  const game = useGame();
  useEffect(() => {
    const { buttons } = game;
    const setting = keysSetting(game);
    const sinceEnd = new SinceEnd();
    const down = (event: KeyboardEvent) => {
      // The page's help opens, which takes the keyboard.
      const before = stream?.snapshot().phase ?? null;
      if (event.key === "?" && before !== null && before !== "paused" && steers(before)) {
        onIntent.current("pause");
      }
      if (event.key === "Meta") releaseAll();
      if (event.ctrlKey || event.metaKey || event.altKey || isElsewhere(event.target)) return;
      const { phase, endedAt } = stream?.snapshot() ?? NO_GAME;
      const keys = readSetting(setting);
      const isForGame = isGameKey(buttons, keys, event);
      const sinceEndMs = sinceEnd.atPress(endedAt, performance.now(), isForGame);
      const intent = intentOf(event, phase, sinceEndMs, keys);
      if (intent && !(isButton(event.target) && pressesButton(event))) {
        event.preventDefault();
        onIntent.current(intent);
      } else if (!stream || phase === null) {
        return;
      } else if (steers(phase) && isForGame) {
        event.preventDefault();
        if (held.hold(placeOf(event), bitOf(buttons, keys, event))) {
          stream.hold(held.bits, event.timeStamp);
        }
      } else if (phase === "ended" && event.repeat && isForGame) {
        // Still held from the game: it must neither scroll the page nor activate a button.
        event.preventDefault();
      }
    };
    const up = (event: KeyboardEvent) => {
      // While it is held, macOS does not tell of other keys that are let go.
      if (event.key === "Meta") releaseAll();
      if (controlOf(readSetting(setting), event) === "rewind") stream?.release();
      if (held.release(placeOf(event))) stream?.hold(held.bits);
    };
    const releaseAll = () => {
      stream?.release();
      if (held.releaseAll()) stream?.hold(0);
    };
    window.addEventListener("keydown", down);
    window.addEventListener("keyup", up);
    for (const loss of LOSSES) window.addEventListener(loss, releaseAll);
    return () => {
      releaseAll();
      window.removeEventListener("keydown", down);
      window.removeEventListener("keyup", up);
      for (const loss of LOSSES) window.removeEventListener(loss, releaseAll);
    };
  }, [stream, held, onIntent, game]);
}

/** Whether the keyboard belongs to a form control or an open dialog. */
function isElsewhere(target: EventTarget | null): boolean {
  if (dialogIsOpen()) return true;
  return target instanceof HTMLElement && target.matches("input, textarea, select");
}

function isButton(target: EventTarget | null): boolean {
  return target instanceof HTMLElement && target.matches("button, a");
}

function pressesButton(pressed: Pressed): boolean {
  return ofSigns({ " ": true, Enter: true }, pressed) ?? false;
}
