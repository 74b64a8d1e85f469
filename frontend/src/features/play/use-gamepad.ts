import { type RefObject, useEffect } from "react";

import { padWishOf, steers, type Wish } from "./controls";
import type { GameStream } from "./game-stream";

import { newlyPressed, NO_PAD, padState } from "@/lib/gamepad";
import type { HeldKeys } from "@/lib/keys";

const NAME = "gamepad";

/** Plays with gamepads. They can only be looked at: once for every frame of the display. */
export function useGamepad(
  stream: GameStream | null,
  held: HeldKeys,
  onWish: RefObject<(wish: Wish) => void>,
): void {
  useEffect(() => {
    if (!stream || !("getGamepads" in navigator)) return undefined;
    let before = NO_PAD;
    let request = 0;
    const look = () => {
      request = requestAnimationFrame(look);
      const pads = document.hasFocus() ? navigator.getGamepads() : [];
      const now = padState(pads);
      const { phase, endedAt } = stream.snapshot();
      if (held.hold(NAME, steers(phase) ? now.bits : 0)) stream.hold(held.bits);
      if (now.rewind && !before.rewind) stream.rewind();
      if (!now.rewind && before.rewind) stream.release();
      for (const button of newlyPressed(before, now)) {
        const wish = padWishOf(button, phase, performance.now() - endedAt);
        if (wish) onWish.current(wish);
      }
      before = now;
    };
    look();
    return () => {
      cancelAnimationFrame(request);
      if (held.release(NAME)) stream.hold(held.bits);
    };
  }, [stream, held, onWish]);
}
