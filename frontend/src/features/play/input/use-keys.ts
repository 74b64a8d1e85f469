import { type RefObject, useEffect } from "react";

import { readSetting } from "@/features/play/settings/stored";
import type { GameStream } from "@/features/play/stream/game-stream";

import { dialogIsOpen } from "./dialogs";
import { type Intent, intentOf, SinceEnd, steers } from "./intents";
import { bitOf, controlOf, type HeldKeys, isGameKey, KEYS } from "./keys";

const NO_GAME = { phase: null, endedAt: 0 };

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
  useEffect(() => {
    const sinceEnd = new SinceEnd();
    const down = (event: KeyboardEvent) => {
      // The page's help opens, which takes the keyboard.
      const before = stream?.snapshot().phase ?? null;
      if (event.key === "?" && before !== null && before !== "paused" && steers(before)) {
        onIntent.current("pause");
      }
      if (event.ctrlKey || event.metaKey || event.altKey || isElsewhere(event.target)) return;
      const { phase, endedAt } = stream?.snapshot() ?? NO_GAME;
      const keys = readSetting(KEYS);
      const isForGame = isGameKey(keys, event.code);
      const sinceEndMs = sinceEnd.atPress(endedAt, performance.now(), isForGame);
      const intent = intentOf(event, phase, sinceEndMs, keys);
      if (intent && !(isButton(event.target) && pressesButton(event.code))) {
        event.preventDefault();
        onIntent.current(intent);
      } else if (!stream || phase === null) {
        return;
      } else if (steers(phase) && isForGame) {
        event.preventDefault();
        if (held.hold(event.code, bitOf(keys, event.code))) {
          stream.hold(held.bits, event.timeStamp);
        }
      } else if (phase === "ended" && event.repeat && isForGame) {
        // Still held from the game: it must neither scroll the page nor activate a button.
        event.preventDefault();
      }
    };
    const up = (event: KeyboardEvent) => {
      if (controlOf(readSetting(KEYS), event.code) === "rewind") stream?.release();
      if (held.release(event.code)) stream?.hold(held.bits);
    };
    const releaseAll = () => {
      stream?.release();
      if (held.releaseAll()) stream?.hold(0);
    };
    window.addEventListener("keydown", down);
    window.addEventListener("keyup", up);
    window.addEventListener("blur", releaseAll);
    return () => {
      releaseAll();
      window.removeEventListener("keydown", down);
      window.removeEventListener("keyup", up);
      window.removeEventListener("blur", releaseAll);
    };
  }, [stream, held, onIntent]);
}

/** Whether the keyboard belongs to a form control or an open dialog. */
function isElsewhere(target: EventTarget | null): boolean {
  if (dialogIsOpen()) return true;
  return target instanceof HTMLElement && target.matches("input, textarea, select");
}

function isButton(target: EventTarget | null): boolean {
  return target instanceof HTMLElement && target.matches("button, a");
}

function pressesButton(code: string): boolean {
  return code === "Space" || code === "Enter" || code === "NumpadEnter";
}
