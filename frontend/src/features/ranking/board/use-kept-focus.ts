import { useCallback, useEffect, useRef } from "react";

import type { Tiers } from "@/features/ranking/order/order";

import type { Move } from "./RankCard";

/**
 * Keeps the focus on the button that moved a card, without a move on its handle: another tier
 * mounts the card anew.
 */
export function useKeptFocus(tiers: Tiers): (id: number, move?: Move) => void {
  const moved = useRef<{ id: number; move: Move | undefined } | null>(null);
  useEffect(() => {
    const { id, move } = moved.current ?? {};
    moved.current = null;
    if (id === undefined || document.activeElement !== document.body) return;
    const card = document.querySelector(`[data-recording="${id}"]`);
    const button = card?.querySelector<HTMLElement>(`[data-move="${move ?? ""}"]`);
    (button ?? card?.querySelector<HTMLElement>("button"))?.focus();
  }, [tiers]);
  return useCallback((id, move) => {
    moved.current = { id, move };
  }, []);
}
