/** The keys that play a recording, wherever the focus is in its player. */
import { ofSigns } from "@/lib/browser/pressed-keys";
import type { Playback } from "@/lib/game/playback";

/** A key that is pressed in a player, as React or a browser reports it. */
type PlayerKey = Pick<
  KeyboardEvent,
  "altKey" | "code" | "ctrlKey" | "key" | "metaKey" | "preventDefault" | "shiftKey" | "target"
>;

/** Plays, pauses or moves by a key; with Shift by a step of so many frames instead of one. */
export function playByKey(
  event: PlayerKey,
  playback: Playback,
  last: number,
  framesPerStep: number,
): void {
  if (event.ctrlKey || event.metaKey || event.altKey) return;
  const target = event.target as HTMLElement;
  if (target.tagName === "SELECT") return;
  const leap = event.shiftKey ? framesPerStep : 1;
  const actions: Readonly<Record<string, () => void>> = {
    ArrowLeft: () => playback.step(-leap),
    ArrowRight: () => playback.step(leap),
    Home: () => playback.seek(0),
    End: () => playback.seek(last),
    " ": () => playback.toggle(),
  };
  const action = ofSigns(actions, event);
  // Space on a focused button or link is its own.
  if (!action || (event.key === " " && /^(BUTTON|A|SUMMARY)$/.test(target.tagName))) return;
  event.preventDefault();
  action();
}
