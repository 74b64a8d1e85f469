/** The keys of a comparison. */
import { type RefObject, useEffect } from "react";

import { type Pressed as Key, signsOf } from "@/lib/browser/keyboard";

export type Act = "game" | "equal" | "opponent" | "skip" | "worst" | "undo" | "play";

/** The keys of each act by their signs; those that are shown first. */
const KEYS: Readonly<Record<Act, readonly string[]>> = {
  game: ["ArrowLeft", "1"],
  equal: ["=", "0"],
  opponent: ["ArrowRight", "2"],
  skip: ["s"],
  worst: ["w"],
  undo: ["u", "Backspace"],
  play: [" "],
};

type Pressed = Key & Pick<KeyboardEvent, "ctrlKey" | "metaKey" | "altKey" | "shiftKey">;

/** Returns what a key does in a comparison; null if nothing. */
export function actOf(event: Pressed): Act | null {
  const signs = signsOf(event);
  if (event.altKey) return null;
  if (event.ctrlKey || event.metaKey) return signs.includes("z") && !event.shiftKey ? "undo" : null;
  const acts = Object.keys(KEYS) as Act[];
  // What it types before what stands at its place.
  const found = signs.map((sign) => acts.find((act) => KEYS[act].includes(sign)));
  return found.find((act) => act !== undefined) ?? null;
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
