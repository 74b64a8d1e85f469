/** The keys of a comparison. */
import { type RefObject, useEffect } from "react";

export type Act = "game" | "equal" | "opponent" | "skip" | "worst" | "undo" | "play";

/** The keys of each act as `KeyboardEvent.key`, in lower case; those that are shown first. */
const KEYS: Readonly<Record<Act, readonly string[]>> = {
  game: ["arrowleft", "1"],
  equal: ["=", "0"],
  opponent: ["arrowright", "2"],
  skip: ["s"],
  worst: ["w"],
  undo: ["u", "backspace"],
  play: [" "],
};

type Pressed = Pick<KeyboardEvent, "key" | "ctrlKey" | "metaKey" | "altKey" | "shiftKey">;

/** Returns what a key does in a comparison; null if nothing. */
export function actOf(event: Pressed): Act | null {
  const key = event.key.toLowerCase();
  if (event.altKey) return null;
  if (event.ctrlKey || event.metaKey) return key === "z" && !event.shiftKey ? "undo" : null;
  const acts = Object.keys(KEYS) as Act[];
  return acts.find((act) => KEYS[act].includes(key)) ?? null;
}

/** Calls what a key stands for while the dialog of an element is the topmost one. */
export function useCompareKeys(
  root: RefObject<HTMLElement | null>,
  acts: Readonly<Record<Act, () => void>>,
): void {
  useEffect(() => {
    const down = (event: KeyboardEvent) => {
      const target = event.target as HTMLElement;
      const act = actOf(event);
      const top = [...document.querySelectorAll("dialog[open]")].at(-1);
      if (!act || !top?.contains(root.current) || belongsTo(target, event.key)) return;
      event.preventDefault();
      // A key that is held answers once.
      if (!event.repeat) acts[act]();
    };
    window.addEventListener("keydown", down);
    return () => window.removeEventListener("keydown", down);
  });
}

/** Whether a key is the focused control's own. */
function belongsTo(target: HTMLElement, key: string): boolean {
  if (target.matches("select")) return true;
  if (target.matches("input")) return key.startsWith("Arrow");
  return target.matches("button, a") && key === " ";
}
