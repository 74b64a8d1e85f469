import { useState, useSyncExternalStore } from "react";

import { dropDraft, readDraft, subscribeToDrafts, writeDraft } from "@/lib/browser/drafts";

export interface Draft<T> {
  readonly value: T;
  readonly set: (value: T) => void;
  /** Forgets it, once it was saved or given up. */
  readonly drop: () => void;
}

/** The content of a form that neither closing it nor leaving or reloading the page loses. */
export function useDraft<T>(key: string, initial: T): Draft<T> {
  const [value, setValue] = useState(() => {
    const kept = readDraft(key);
    return isLike(kept, initial) ? kept : initial;
  });
  return {
    value,
    set: (next) => {
      if (JSON.stringify(next) === JSON.stringify(initial)) dropDraft(key);
      else writeDraft(key, next);
      setValue(next);
    },
    drop: () => dropDraft(key),
  };
}

/** Whether there is a draft. */
export function useHasDraft(key: string): boolean {
  return useSyncExternalStore(subscribeToDrafts, () => readDraft(key) !== undefined);
}

/** Whether a draft is of this version of its form. */
function isLike<T>(kept: unknown, initial: T): kept is T {
  if (typeof kept !== typeof initial || kept === null) return false;
  if (typeof initial !== "object" || initial === null) return true;
  return Object.keys(initial).every((name) => name in (kept as object));
}
