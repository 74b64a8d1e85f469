/** The keys of a comparison of two games. */
import { type RefObject, useEffect } from "react";

import { type Pressed as Key, signsOf } from "@/lib/browser/pressed-keys";

type Pressed = Key & Pick<KeyboardEvent, "ctrlKey" | "metaKey" | "altKey" | "shiftKey">;

/** The signs of keys by what they do. */
type Keys<Act extends string> = Readonly<Record<Act, readonly string[]>>;

/** The keys of every comparison. */
const ANSWER_KEYS = {
  first: ["ArrowLeft", "1"],
  equal: ["=", "0"],
  second: ["ArrowRight", "2"],
  undo: ["u", "Backspace"],
  play: [" "],
} as const;

export type AnswerAct = keyof typeof ANSWER_KEYS;

/** Returns what a key does in a comparison that has further keys; null if nothing. */
export function actOf<Further extends string>(
  event: Pressed,
  further: Keys<Further>,
): Further | AnswerAct | null {
  const keys: Keys<Further | AnswerAct> = { ...further, ...ANSWER_KEYS };
  const signs = signsOf(event);
  if (event.altKey) return null;
  if (event.ctrlKey || event.metaKey) return signs.includes("z") && !event.shiftKey ? "undo" : null;
  const acts = Object.keys(keys) as (Further | AnswerAct)[];
  // What it types before what stands at its place.
  const found = signs.map((sign) => acts.find((act) => keys[act].includes(sign)));
  return found.find((act) => act !== undefined) ?? null;
}

/** Calls what a key stands for while the dialog of an element is the topmost one. */
export function useAnswerKeys(
  root: RefObject<HTMLElement | null>,
  acts: Readonly<Record<AnswerAct, () => void>>,
  /** What further keys do, by the sign that they type. */
  further: Readonly<Record<string, () => void>>,
): void {
  useEffect(() => {
    const down = (event: KeyboardEvent) => {
      const target = event.target as HTMLElement;
      const all: Readonly<Record<string, () => void>> = { ...further, ...acts };
      const keys = Object.fromEntries(Object.keys(further).map((sign) => [sign, [sign]]));
      const act = actOf(event, keys);
      const top = [...document.querySelectorAll("dialog[open]")].at(-1);
      if (!act || !top?.contains(root.current) || belongsTo(target, event.key)) return;
      event.preventDefault();
      // A key that is held answers once.
      if (!event.repeat) all[act]?.();
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
