import { useEffect } from "react";

import type { RankingSaver } from "./saver";

/** Ctrl+Z undoes, Ctrl+Shift+Z or Ctrl+Y redoes, while that is enabled. */
export function useUndoKeys(saver: RankingSaver, enabled: boolean): void {
  useEffect(() => {
    if (!enabled) return undefined;
    const down = (event: KeyboardEvent) => {
      const target = event.target as HTMLElement;
      if (!(event.ctrlKey || event.metaKey) || target.matches("input, textarea")) return;
      const key = event.key.toLowerCase();
      if (key !== "z" && key !== "y") return;
      event.preventDefault();
      void saver.step(key === "y" || event.shiftKey ? "redo" : "undo");
    };
    window.addEventListener("keydown", down);
    return () => window.removeEventListener("keydown", down);
  }, [saver, enabled]);
}
