import { type RefObject, useEffect, useRef, useState } from "react";

import type { GameStream } from "@/features/play/stream/game-stream";
import { useGame } from "@/games/game";

import { dialogIsOpen } from "./dialogs";
import { newlyPressed, Pads, type PadState } from "./gamepad";
import { gamepadIntentOf, type Intent, SinceEnd, steers } from "./intents";
import type { HeldKeys } from "./keys";

const NAME = "gamepad";

/**
 * Plays with gamepads, and starts the first game with one. The Gamepad API has no events for
 * buttons, so they are polled once per display frame.
 *
 * @param stream Null before the first game.
 */
export function useGamepad(
  stream: GameStream | null,
  held: HeldKeys,
  onIntent: RefObject<(intent: Intent) => void>,
): void {
  const { buttons } = useGame();
  // A button held since before the game does not count as pressed in it.
  const before = useRef<PadState | null>(null);
  const [pads] = useState(() => new Pads());
  useEffect(() => {
    if (!("getGamepads" in navigator)) return undefined;
    let request = 0;
    const sinceEnd = new SinceEnd();
    const look = () => {
      request = requestAnimationFrame(look);
      const now = pads.read(document.hasFocus() ? navigator.getGamepads() : [], buttons);
      const last = before.current ?? now;
      before.current = now;
      const { phase, endedAt } = stream?.snapshot() ?? { phase: null, endedAt: 0 };
      if (stream && phase) {
        if (held.hold(NAME, steers(phase) ? now.bits : 0)) stream.hold(held.bits);
        if (now.rewind && !last.rewind) stream.rewind();
        if (!now.rewind && last.rewind) stream.release();
      }
      for (const button of newlyPressed(last, now)) {
        const sinceEndMs = sinceEnd.atPress(endedAt, performance.now(), true);
        const intent = gamepadIntentOf(button, phase, sinceEndMs);
        if (intent && !dialogIsOpen()) onIntent.current(intent);
      }
    };
    look();
    return () => {
      cancelAnimationFrame(request);
      if (held.release(NAME)) stream?.hold(held.bits);
    };
  }, [stream, held, onIntent, pads, buttons]);
}
