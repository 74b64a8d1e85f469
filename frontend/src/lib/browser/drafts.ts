/**
 * What a person did that is not saved yet. It outlives the view, and a reload where the browser
 * stores it; closing or leaving the page asks first.
 */
import { ofTab } from "@/lib/browser/storage";

const STORAGE_KEY = "tril.drafts";

const listeners = new Set<() => void>();
/** What would be lost if the page were closed now. */
const unsaved = new Set<string>();

/** Returns a draft, as it was stored; undefined if there is none. */
export function readDraft(key: string): unknown {
  return all()[key];
}

export function writeDraft(key: string, value: unknown): void {
  store({ ...all(), [key]: value });
  setUnsaved(key, true);
}

/** Forgets a draft that was saved or given up. */
export function dropDraft(key: string): void {
  const drafts = all();
  if (key in drafts)
    store(Object.fromEntries(Object.entries(drafts).filter(([draftKey]) => draftKey !== key)));
  setUnsaved(key, false);
}

/** Forgets all drafts, which are one person's. */
export function forgetDrafts(): void {
  store({});
  [...unsaved].forEach((draft) => setUnsaved(draft, false));
}

export function subscribeToDrafts(listener: () => void): () => void {
  listeners.add(listener);
  return () => listeners.delete(listener);
}

/** Has leaving the page ask as long as something is not saved. */
export function setUnsaved(draft: string, is: boolean): void {
  if (is) unsaved.add(draft);
  else unsaved.delete(draft);
  if (typeof window === "undefined") return;
  // A page that always listens is never kept for the browser's way back.
  if (unsaved.size > 0) window.addEventListener("beforeunload", ask);
  else window.removeEventListener("beforeunload", ask);
}

function ask(event: BeforeUnloadEvent): void {
  event.preventDefault();
}

function all(): Readonly<Record<string, unknown>> {
  return JSON.parse(ofTab.read(STORAGE_KEY) ?? "{}") as Record<string, unknown>;
}

function store(drafts: Readonly<Record<string, unknown>>): void {
  ofTab.write(STORAGE_KEY, JSON.stringify(drafts));
  listeners.forEach((listener) => listener());
}
