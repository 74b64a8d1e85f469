/** Settings kept in this browser's local storage. */
import { useCallback, useSyncExternalStore } from "react";

import { ofBrowser } from "@/lib/browser/storage";

/** A setting with its storage key. */
export interface Setting<T> {
  readonly key: string;
  readonly fallback: T;
  /** Validates a stored value; null if it is invalid. */
  readonly read: (stored: unknown) => T | null;
}

const listeners = new Set<() => void>();
/** The last value read of each setting, so that unchanged values keep their identity. */
const cache = new Map<string, { readonly stored: string | null; readonly value: unknown }>();

/** A boolean setting. */
export function onOff(key: string, fallback: boolean): Setting<boolean> {
  return { key, fallback, read: (stored) => (typeof stored === "boolean" ? stored : null) };
}

export function readSetting<T>({ key, fallback, read }: Setting<T>): T {
  const stored = ofBrowser.read(key);
  const before = cache.get(key);
  if (before?.stored === stored) return before.value as T;
  const value = (stored === null ? null : read(parsed(stored))) ?? fallback;
  cache.set(key, { stored, value });
  return value;
}

export function writeSetting<T>({ key }: Setting<T>, value: T): void {
  const stored = JSON.stringify(value);
  ofBrowser.write(key, stored);
  cache.set(key, { stored, value });
  listeners.forEach((listener) => listener());
}

/** Returns a setting and its setter; every component that uses it updates. */
export function useSetting<T>(setting: Setting<T>): readonly [T, (value: T) => void] {
  const value = useSyncExternalStore(subscribe, () => readSetting(setting));
  const change = useCallback((next: T) => writeSetting(setting, next), [setting]);
  return [value, change];
}

function subscribe(listener: () => void): () => void {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

function parsed(text: string): unknown {
  try {
    return JSON.parse(text) as unknown;
  } catch {
    return null;
  }
}
