import { useState } from "react";

/** What was typed into dialogs that were closed before it was saved, until the page is left. */
const drafts = new Map<string, unknown>();

export interface Draft<T> {
  readonly value: T;
  readonly set: (value: T) => void;
  /** Forgets it, once it was saved or given up. */
  readonly drop: () => void;
}

/** The content of a form that a dialog loses neither to Escape nor to a click beside it. */
export function useDraft<T>(key: string, initial: T): Draft<T> {
  const [value, setValue] = useState(() => (drafts.has(key) ? (drafts.get(key) as T) : initial));
  return {
    value,
    set: (next) => {
      drafts.set(key, next);
      setValue(next);
    },
    drop: () => drafts.delete(key),
  };
}

/** Forgets all of them, as leaving the page does. */
export function forgetDrafts(): void {
  drafts.clear();
}
