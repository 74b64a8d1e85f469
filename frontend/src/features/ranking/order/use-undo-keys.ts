import { useEffect } from "react";

import { ofSigns } from "@/lib/browser/pressed-keys";

/** Ctrl+Z undoes, Ctrl+Shift+Z or Ctrl+Y redoes, while that is enabled. */
export function useUndoKeys(onStep: (step: "undo" | "redo") => void, enabled: boolean): void {
  useEffect(() => {
    if (!enabled) return undefined;
    const down = (event: KeyboardEvent) => {
      const target = event.target as HTMLElement;
      if (!(event.ctrlKey || event.metaKey) || target.matches("input, textarea")) return;
      const step = ofSigns({ z: event.shiftKey ? "redo" : "undo", y: "redo" } as const, event);
      if (!step) return;
      event.preventDefault();
      onStep(step);
    };
    window.addEventListener("keydown", down);
    return () => window.removeEventListener("keydown", down);
  }, [onStep, enabled]);
}
