/** Small choices that this browser keeps. */
import { useCallback, useSyncExternalStore } from "react";

/** A choice: its name in the browser's storage, what it is without one, and how it is read. */
export interface Setting<T> {
  readonly key: string;
  readonly fallback: T;
  /** What was stored as a value of the choice; null if it is none. */
  readonly read: (stored: unknown) => T | null;
}

const listeners = new Set<() => void>();
/** What was read of each choice, by what was stored: a value keeps its identity. */
const known = new Map<string, { readonly stored: string | null; readonly value: unknown }>();

/** A choice that is on or off. */
export function onOff(key: string, fallback: boolean): Setting<boolean> {
  return { key, fallback, read: (stored) => (typeof stored === "boolean" ? stored : null) };
}

export function readSetting<T>({ key, fallback, read }: Setting<T>): T {
  const stored = textAt(key);
  const before = known.get(key);
  if (before?.stored === stored) return before.value as T;
  const value = (stored === null ? null : read(parsed(stored))) ?? fallback;
  known.set(key, { stored, value });
  return value;
}

export function writeSetting<T>({ key }: Setting<T>, value: T): void {
  try {
    localStorage.setItem(key, JSON.stringify(value));
  } catch {
    // Storage is closed or full: the choice holds until the page is left.
  }
  known.set(key, { stored: textAt(key), value });
  listeners.forEach((listener) => listener());
}

/** A choice and how to change it; all that show it change with it. */
export function useSetting<T>(choice: Setting<T>): readonly [T, (value: T) => void] {
  const value = useSyncExternalStore(subscribe, () => readSetting(choice));
  const change = useCallback((next: T) => writeSetting(choice, next), [choice]);
  return [value, change];
}

function subscribe(listener: () => void): () => void {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

function textAt(key: string): string | null {
  try {
    return localStorage.getItem(key);
  } catch {
    return null;
  }
}

function parsed(text: string): unknown {
  try {
    return JSON.parse(text) as unknown;
  } catch {
    return null;
  }
}
