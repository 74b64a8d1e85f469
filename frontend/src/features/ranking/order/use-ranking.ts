import { type QueryClient, useQueryClient } from "@tanstack/react-query";
import { useEffect, useState, useSyncExternalStore } from "react";

import { isPassing } from "@/api/client";
import type { Ranking } from "@/api/types";
import { dropDraft, readDraft, writeDraft } from "@/lib/browser/drafts";

import { sameOrder, type Tiers } from "./order";
import { RankingConflictError, rankingQuery, saveRanking, stepRanking } from "./rankings";
import { RankingSaver, type SaverState } from "./saver";

/** Returns the state of the ranking and its saver. */
export function useRankingSaver(ranking: Ranking): [SaverState, RankingSaver] {
  const client = useQueryClient();
  const [saver] = useState(() => saverOf(client, ranking));
  useEffect(() => saver.begin(), [saver]);
  useEffect(() => saver.receive(ranking), [saver, ranking]);
  const state = useSyncExternalStore(saver.subscribe, saver.snapshot);
  return [state, saver];
}

/** Those whose order is not saved, by behaviour: they go on saving when the page is left. */
const unsavedOf = new WeakMap<QueryClient, Map<number, RankingSaver>>();

/** An order that is not saved, as a reload finds it. */
interface Unsaved {
  readonly base: number;
  readonly tiers: Tiers;
}

function saverOf(client: QueryClient, ranking: Ranking): RankingSaver {
  const unsaved = unsavedOf.get(client) ?? new Map<number, RankingSaver>();
  unsavedOf.set(client, unsaved);
  const behaviourId = ranking.behaviour_id;
  const known = unsaved.get(behaviourId);
  if (known) return known;

  const { queryKey } = rankingQuery(behaviourId);
  const cached = async (answer: Promise<Ranking>): Promise<Ranking> => {
    // A response still in flight could be older than this one.
    await client.cancelQueries({ queryKey });
    const saved = await answer;
    client.setQueryData(queryKey, saved);
    void client.invalidateQueries({ queryKey: ["behaviours"] });
    return saved;
  };
  const backend = {
    save: (base: number, tiers: Tiers) => cached(saveRanking(behaviourId, base, tiers)),
    step: (base: number, step: "undo" | "redo") => cached(stepRanking(behaviourId, base, step)),
    conflictOf: (error: unknown) => (error instanceof RankingConflictError ? error.current : null),
  };
  const draft = draftKey(behaviourId);
  const stored = readDraft(draft) as Unsaved | undefined;
  let saver;
  if (stored && !sameOrder(stored.tiers, ranking.tiers)) {
    // On a revision that is outdated by now it is a conflict, which the person decides.
    saver = new RankingSaver({ ...ranking, revision: stored.base }, backend, stored.tiers);
    unsaved.set(behaviourId, saver);
  } else {
    saver = new RankingSaver(ranking, backend);
    dropDraft(draft);
  }
  saver.subscribe(() => {
    if (saver.isUnsaved()) {
      const { saved, tiers } = saver.snapshot();
      unsaved.set(behaviourId, saver);
      writeDraft(draft, { base: saved.revision, tiers } satisfies Unsaved);
    } else if (unsaved.delete(behaviourId)) dropDraft(draft);
  });
  saveAgain(saver, draft);
  return saver;
}

/** The draft of a behaviour's order, which the training form knows by this name, too. */
function draftKey(behaviourId: number): string {
  return `ranking ${behaviourId}`;
}

const RETRY_MS = 5000;

/** Saves again after a failure that may pass: regularly, and once the network is back. */
function saveAgain(saver: RankingSaver, draft: string): void {
  let stop: (() => void) | null = null;
  saver.subscribe(() => {
    const { error } = saver.snapshot();
    const isWaiting = error !== null && isPassing(error);
    if (isWaiting === (stop !== null)) return;
    stop?.();
    stop = null;
    if (!isWaiting) return;
    const retry = () => {
      // The order of a person who signed out is not the next one's.
      if (!saver.isUnsaved() || readDraft(draft) !== undefined) saver.retry();
    };
    const timer = setTimeout(retry, RETRY_MS);
    window.addEventListener("online", retry);
    stop = () => {
      clearTimeout(timer);
      window.removeEventListener("online", retry);
    };
  });
}
