/**
 * A behaviour's library: all recordings in brief, of which only what changed is fetched again, and
 * the recordings themselves, fetched as they are shown.
 */
import { queryOptions, skipToken, useQueries, useQuery } from "@tanstack/react-query";

import { inBatches } from "./batches";
import { api, ProblemError, unwrap } from "./client";
import type { Library, LibraryColumns, LibraryEntry, Recording } from "./types";

/** A library as the page keeps it. */
export interface KnownLibrary {
  /** What changed after it is not known yet. */
  readonly cursor: number;
  /** Newest first. */
  readonly entries: readonly LibraryEntry[];
}

/** Recordings that are fetched, and shown, before the others. */
const N_NEWEST = 200;
/** Recordings that are fetched at once after them; the server does one request of a person at a time. */
const PART_LENGTH = 2000;

/** A behaviour's kept, unfinished and undecided recordings in brief, newest first. */
export function libraryQuery(behaviourId: number, { deleted = false } = {}) {
  const queryKey: readonly unknown[] = deleted
    ? ["recordings", behaviourId, "with deleted"]
    : ["recordings", behaviourId];
  return queryOptions({
    queryKey,
    queryFn: async ({ client, signal }): Promise<KnownLibrary> => {
      const fetchPart = (part: { since?: number; before?: number; limit?: number }) =>
        unwrap(
          api.GET("/api/behaviours/{behaviour_id}/library", {
            params: {
              path: { behaviour_id: behaviourId },
              query: { ...part, ...(deleted && { deleted }) },
            },
            signal,
          }),
        );
      const known = client.getQueryData<KnownLibrary>(queryKey);
      if (known) return withChanges(known, await fetchPart({ since: known.cursor }));
      const first = await fetchPart({ limit: N_NEWEST });
      const { cursor, entries } = withChanges(undefined, first);
      if (first.whole) return { cursor, entries };
      client.setQueryData(newestQuery(behaviourId, { deleted }).queryKey, entries);
      const all = [...entries];
      for (let isLast = false; !isLast;) {
        const before = all.at(-1)?.id ?? 1;
        const { recordings, ranked } = await fetchPart({ before, limit: PART_LENGTH });
        all.push(...entriesOf(recordings, new Set(ranked)));
        isLast = recordings.id.length < PART_LENGTH;
      }
      // What changed while the parts were fetched.
      return withChanges({ cursor, entries: all }, await fetchPart({ since: cursor }));
    },
    // Comparing tens of thousands of entries would take longer than keeping those that are equal.
    structuralSharing: false,
  });
}

/** The newest recordings of a library whose others are still fetched. */
function newestQuery(behaviourId: number, { deleted = false } = {}) {
  return queryOptions<readonly LibraryEntry[]>({
    queryKey: [...libraryQuery(behaviourId, { deleted }).queryKey, "newest"],
    queryFn: skipToken,
  });
}

/** Returns a behaviour's recordings, newest first, or only the newest until all are there. */
export function useLibrary(behaviourId: number) {
  const { data: whole, error, refetch } = useQuery(libraryQuery(behaviourId));
  const { data: newest } = useQuery(newestQuery(behaviourId));
  return { entries: whole?.entries ?? newest, isWhole: whole !== undefined, error, refetch };
}

/** The games that a behaviour has borrowed for its ranking, in brief, newest first. */
export function borrowedQuery(behaviourId: number) {
  return queryOptions({
    // Stale whenever the behaviour's own recordings are.
    queryKey: ["recordings", behaviourId, "borrowed"],
    queryFn: async ({ signal }): Promise<readonly LibraryEntry[]> => {
      const answer = await unwrap(
        api.GET("/api/behaviours/{behaviour_id}/borrowed", {
          params: { path: { behaviour_id: behaviourId } },
          signal,
        }),
      );
      const entries = entriesOf(answer.recordings, new Set(answer.ranked));
      return entries.map((one) => ({ ...one, borrowed: true }));
    },
  });
}

/** The server's limit on recordings that one address names. */
const MOST_AT_ONCE = 100;
/** For how long a recording out of sight is kept. */
const KEPT_MS = 60_000;

const shown = new Map<number, (id: number, signal: AbortSignal) => Promise<Recording>>();

/** A recording as it is shown for a behaviour, which may have borrowed it; even a deleted one. */
export function shownQuery(behaviourId: number, recordingId: number) {
  return queryOptions({
    queryKey: ["recording", recordingId, "for", behaviourId],
    queryFn: async ({ signal }) => {
      let fetchOne = shown.get(behaviourId);
      if (!fetchOne) {
        fetchOne = inBatches((ids) => fetchShown(behaviourId, ids), MOST_AT_ONCE);
        shown.set(behaviourId, fetchOne);
      }
      return fetchOne(recordingId, signal);
    },
    gcTime: KEPT_MS,
  });
}

/** Returns those of some recordings that are there, as they are shown for a behaviour. */
export function useShown(
  behaviourId: number,
  ids: readonly number[],
): ReadonlyMap<number, Recording> {
  return useQueries({
    queries: [...new Set(ids)].map((id) => shownQuery(behaviourId, id)),
    combine: (answers) =>
      new Map(answers.flatMap(({ data }) => (data ? [[data.id, data] as const] : []))),
  });
}

async function fetchShown(
  behaviourId: number,
  ids: readonly number[],
): Promise<(id: number) => Recording> {
  const answer = await unwrap(
    api.GET("/api/behaviours/{behaviour_id}/library/recordings", {
      params: { path: { behaviour_id: behaviourId }, query: { recording: [...ids] } },
    }),
  );
  const byId = new Map(answer.map((one) => [one.id, one]));
  return (id) => {
    const found = byId.get(id);
    if (!found) throw new ProblemError(404, `There is no recording ${id} (any more).`, null);
    return found;
  };
}

/** Returns a library with what changed; entries that did not are the same objects as before. */
export function withChanges(known: KnownLibrary | undefined, answer: Library): KnownLibrary {
  const { cursor } = answer;
  const ranked = new Set(answer.ranked);
  const changed = entriesOf(answer.recordings, ranked);
  if (answer.whole || !known) return { cursor, entries: changed };
  const isSame = changed.length === 0 && answer.removed.length === 0;
  if (isSame && known.entries.every((one) => one.ranked === ranked.has(one.id)))
    return { cursor, entries: known.entries };
  const gone = new Set([...answer.removed, ...changed.map(({ id }) => id)]);
  const rest = known.entries
    .filter(({ id }) => !gone.has(id))
    .map((one) => (one.ranked === ranked.has(one.id) ? one : { ...one, ranked: !one.ranked }));
  return { cursor, entries: merged(changed, rest) };
}

/** Merges entries that are sorted by falling numbers. */
function merged(
  changed: readonly LibraryEntry[],
  rest: readonly LibraryEntry[],
): readonly LibraryEntry[] {
  if (changed.length === 0) return rest;
  return [...changed, ...rest].sort((a, b) => b.id - a.id);
}

/** Returns the rows of columns. */
function entriesOf(columns: LibraryColumns, ranked: ReadonlySet<number>): LibraryEntry[] {
  const counters = Object.entries(columns.counters);
  return columns.id.map((id, row) => {
    const of = <T>(column: readonly T[]) => column[row] as T;
    const parent = of(columns.parent_id);
    const frame = of(columns.parent_frame);
    return {
      id,
      number: of(columns.number),
      behaviour_name: of(columns.behaviour_name),
      borrowed: false,
      source: of(columns.source),
      player: of(columns.player),
      run_id: of(columns.run_id),
      parent:
        parent === null || frame === null ? null : { recording_id: parent, number: null, frame },
      state: of(columns.state),
      verification: of(columns.verification),
      n_frames: of(columns.n_frames),
      n_steps: of(columns.n_steps),
      end: of(columns.end),
      hits: numberOf(of(columns.n_hits)),
      targets: of(columns.targets),
      strays: of(columns.strays),
      order_errors: of(columns.order_errors),
      counters: Object.fromEntries(counters.map(([name, counts]) => [name, of(counts)])),
      score: of(columns.score),
      perfect: of(columns.perfect),
      ranked: ranked.has(id),
      deleted: of(columns.deleted),
    };
  });
}

const numbers = new Map<number, { readonly length: number }>();

/** Returns the same object for the same number, so that tens of thousands share a few. */
function numberOf(length: number): { readonly length: number } {
  const known = numbers.get(length) ?? { length };
  numbers.set(length, known);
  return known;
}

/** Borrows games for a behaviour's ranking, unranked; all or none. */
export function addGames(behaviourId: number, ids: readonly number[]): Promise<Recording[]> {
  return unwrap(
    api.POST("/api/behaviours/{behaviour_id}/ranking/games", {
      params: { path: { behaviour_id: behaviourId } },
      body: { recording_ids: [...ids] },
    }),
  );
}

/** Gives a borrowed recording back, which is refused while it is ranked. */
export function giveBack(behaviourId: number, recordingId: number): Promise<unknown> {
  return unwrap(
    api.DELETE("/api/behaviours/{behaviour_id}/borrowed/{recording_id}", {
      params: { path: { behaviour_id: behaviourId, recording_id: recordingId } },
    }),
  );
}
