/** What is printed on the keys of this keyboard. */
import { useSyncExternalStore } from "react";

type Labels = ReadonlyMap<string, string>;

/** What is printed on the keys of this keyboard, by code, as far as it is known. */
class Layout {
  private labels: Labels = new Map();
  private readonly listeners = new Set<() => void>();

  readonly subscribe = (listener: () => void): (() => void) => {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  };

  readonly snapshot = (): Labels => this.labels;

  /** Asks the browser, if it tells; otherwise keys are learned as they are pressed. */
  async ask(): Promise<void> {
    const { keyboard } = navigator as { keyboard?: { getLayoutMap: () => Promise<Labels> } };
    try {
      const labels = await keyboard?.getLayoutMap();
      if (labels) this.update(new Map([...this.labels, ...labels]));
    } catch {
      // Not told to this page.
    }
  }

  learn(event: KeyboardEvent): void {
    const { code, key } = event;
    const isPlain = !(event.ctrlKey || event.metaKey || event.altKey || event.shiftKey);
    const label = key.toLowerCase();
    if (!isPlain || !/^\S$/u.test(key) || code === "" || code.startsWith("Numpad")) return;
    if (this.labels.get(code) !== label) this.update(new Map([...this.labels, [code, label]]));
  }

  private update(labels: Labels): void {
    this.labels = labels;
    this.listeners.forEach((listener) => listener());
  }
}

const layout = new Layout();

/** Follows the keyboard's layout from now on; returns what ends that. */
export function followLayout(): () => void {
  const learn = (event: KeyboardEvent) => layout.learn(event);
  void layout.ask();
  window.addEventListener("keydown", learn, { capture: true });
  return () => window.removeEventListener("keydown", learn, { capture: true });
}

/** What is printed on the keys, by code, as far as it is known. */
export function useKeyLabels(): Labels {
  return useSyncExternalStore(layout.subscribe, layout.snapshot);
}
