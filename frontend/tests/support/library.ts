/** A fake server's answers about a library. */
import type { Library, LibraryEntry, Recording } from "@/api/types";

import type { Asked } from "./server";

type Row = Recording | LibraryEntry;

/** Recordings in brief, as the server answers them. */
export function libraryOf(list: readonly Row[], change: Partial<Library> = {}): Library {
  const column = <T>(of: (one: Row) => T) => list.map(of);
  return {
    cursor: 1,
    whole: true,
    removed: [],
    ranked: rankedOf(list),
    recordings: {
      id: column(({ id }) => id),
      number: column(({ number }) => number),
      behaviour_name: column(({ borrowed, behaviour_name: name }) => (borrowed ? name : null)),
      source: column(({ source }) => source),
      player: column(({ player }) => player),
      run_id: column(({ run_id }) => run_id),
      parent_id: column(({ parent }) => parent?.recording_id ?? null),
      parent_frame: column(({ parent }) => parent?.frame ?? null),
      state: column(({ state }) => state),
      verification: column(({ verification }) => verification),
      n_frames: column(({ n_frames }) => n_frames),
      n_steps: column(({ n_steps }) => n_steps),
      end: column(({ end }) => end),
      n_hits: column(({ hits }) => hits.length),
      targets: column(({ targets }) => targets),
      strays: column(({ strays }) => strays),
      order_errors: column(({ order_errors }) => order_errors),
      counters: { shots: column(({ counters }) => counters.shots ?? 0) },
      score: column(({ score }) => score),
      measured: [],
      perfect: column(({ perfect }) => perfect),
      deleted: column(({ deleted }) => deleted),
    },
    ...change,
  };
}

/** The part of a library that a request asks for. */
export function partOf(list: readonly Row[], query: URLSearchParams): Library {
  if (query.has("since")) return libraryOf([], { whole: false, ranked: rankedOf(list) });
  const before = Number(query.get("before") ?? Infinity);
  const limit = Number(query.get("limit") ?? Infinity);
  const part = list.filter(({ id }) => id < before).slice(0, limit);
  const whole = before === Infinity && part.length < limit;
  return libraryOf(part, { whole, ranked: rankedOf(list) });
}

const rankedOf = (list: readonly Row[]) => list.filter(({ ranked }) => ranked).map(({ id }) => id);

/** Answers of a server that has these recordings of behaviour 1, borrowed ones among them. */
export function libraryRoutes(
  list: () => readonly Recording[],
  deleted: () => readonly Recording[] = () => [],
) {
  const every = () => [...list(), ...deleted()];
  return {
    "GET /api/behaviours/1/library": ({ query }: Asked) =>
      libraryOf((query.has("deleted") ? every() : list()).filter(({ borrowed }) => !borrowed)),
    "GET /api/behaviours/1/library/recordings": ({ query }: Asked) => {
      const ids = new Set(query.getAll("recording").map(Number));
      return every().filter(({ id }) => ids.has(id));
    },
    "GET /api/behaviours/1/borrowed": () => libraryOf(list().filter(({ borrowed }) => borrowed)),
  };
}
