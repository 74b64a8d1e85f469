import { type RefObject, useEffect, useRef } from "react";

import type { GameStream } from "@/features/play/stream/game-stream";

import { dialogIsOpen } from "./dialogs";
import { newlyPressed, type PadState, padState } from "./gamepad";
import { padWishOf, steers, type Wish } from "./intents";
import type { HeldKeys } from "./keys";

const NAME = "gamepad";

/**
 * Plays with gamepads, and starts the first game with one. They can only be looked at: once for
 * every frame of the display.
 *
 * @param stream Null before the first game.
 */
export function useGamepad(
  stream: GameStream | null,
  held: HeldKeys,
  onWish: RefObject<(wish: Wish) => void>,
): void {
  // What is held when a game begins was not pressed in it.
  const before = useRef<PadState | null>(null);
  useEffect(() => {
    if (!("getGamepads" in navigator)) return undefined;
    let request = 0;
    const look = () => {
      request = requestAnimationFrame(look);
      const now = padState(document.hasFocus() ? navigator.getGamepads() : []);
      const last = before.current ?? now;
      before.current = now;
      const { phase, endedAt } = stream?.snapshot() ?? { phase: null, endedAt: 0 };
      if (stream && phase) {
        if (held.hold(NAME, steers(phase) ? now.bits : 0)) stream.hold(held.bits);
        if (now.rewind && !last.rewind) stream.rewind();
        if (!now.rewind && last.rewind) stream.release();
      }
      for (const button of newlyPressed(last, now)) {
        const wish = padWishOf(button, phase, performance.now() - endedAt);
        if (wish && !dialogIsOpen()) onWish.current(wish);
      }
    };
    look();
    return () => {
      cancelAnimationFrame(request);
      if (held.release(NAME)) stream?.hold(held.bits);
    };
  }, [stream, held, onWish]);
}
