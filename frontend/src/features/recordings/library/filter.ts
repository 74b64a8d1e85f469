/** The library's filter and order, and how the address encodes them. */
import type { LibraryEntry } from "@/api/types";

export const SHOWN = ["all", "perfect", "ranked", "unranked", "deleted"] as const;
export const SOURCES = ["person", "scripted", "policy", "varied"] as const;
export const VERIFIED = ["yes", "no"] as const;
export const ORDERS = [
  "newest",
  "oldest",
  "targets",
  "strays",
  "longest",
  "shots",
  "score",
] as const;

export interface Filter {
  readonly show: (typeof SHOWN)[number];
  readonly source: (typeof SOURCES)[number] | null;
  readonly player: string | null;
  readonly verified: (typeof VERIFIED)[number] | null;
  /** At least so many target hits, or hits if there is no target. */
  readonly hits: number | null;
  /** At most so many strays. */
  readonly strays: number | null;
  /** The digits that its number begins with. */
  readonly number: string | null;
  readonly order: (typeof ORDERS)[number];
}

export const EVERYTHING: Filter = {
  show: "all",
  source: null,
  player: null,
  verified: null,
  hits: null,
  strays: null,
  number: null,
  order: "newest",
};

/** Reads the filter from an address, ignoring invalid values. */
export function readFilter(search: URLSearchParams): Filter {
  return {
    show: oneOf(SHOWN, search.get("show")) ?? EVERYTHING.show,
    source: oneOf(SOURCES, search.get("source")),
    player: search.get("player"),
    verified: oneOf(VERIFIED, search.get("verified")),
    hits: wholeNumber(search.get("hits")),
    strays: wholeNumber(search.get("strays")),
    number: /^\d{1,10}$/.exec(search.get("number") ?? "")?.[0] ?? null,
    order: oneOf(ORDERS, search.get("order")) ?? EVERYTHING.order,
  };
}

/** Encodes a filter for an address, omitting defaults. */
export function writeFilter(filter: Filter): URLSearchParams {
  const search = new URLSearchParams();
  for (const key of Object.keys(EVERYTHING) as (keyof Filter)[]) {
    const value = filter[key];
    if (value !== null && value !== EVERYTHING[key]) search.set(key, String(value));
  }
  return search;
}

/** Whether a filter excludes anything. */
export function isNarrow(filter: Filter): boolean {
  return writeFilter({ ...filter, order: EVERYTHING.order }).size > 0;
}

/** Returns the recordings that match a filter, in its order. */
export function filtered(recordings: readonly LibraryEntry[], filter: Filter): LibraryEntry[] {
  return recordings.filter((one) => fits(one, filter)).sort(COMPARE[filter.order]);
}

function fits(one: LibraryEntry, filter: Filter): boolean {
  const { source, player, verified, hits, strays, number } = filter;
  return (
    SHOWS[filter.show](one) &&
    (source === null || one.source === source) &&
    (player === null || one.player === player) &&
    (verified === null || (one.verification === "verified") === (verified === "yes")) &&
    (hits === null || hitsOf(one) >= hits) &&
    (strays === null || (one.strays ?? 0) <= strays) &&
    (number === null || String(one.id).startsWith(number))
  );
}

const SHOWS: Readonly<Record<Filter["show"], (one: LibraryEntry) => boolean>> = {
  all: (one) => !one.deleted,
  perfect: (one) => !one.deleted && one.perfect,
  ranked: (one) => !one.deleted && one.ranked,
  unranked: (one) => !one.deleted && !one.ranked,
  deleted: (one) => one.deleted,
};

type Compare = (a: LibraryEntry, b: LibraryEntry) => number;

const newest: Compare = (a, b) => b.id - a.id;
const COMPARE: Readonly<Record<Filter["order"], Compare>> = {
  newest,
  oldest: (a, b) => a.id - b.id,
  targets: (a, b) => hitsOf(b) - hitsOf(a) || (a.strays ?? 0) - (b.strays ?? 0) || newest(a, b),
  strays: (a, b) => (a.strays ?? 0) - (b.strays ?? 0) || hitsOf(b) - hitsOf(a) || newest(a, b),
  longest: (a, b) => b.n_frames - a.n_frames || newest(a, b),
  score: (a, b) => (b.score ?? 0) - (a.score ?? 0) || newest(a, b),
  shots: (a, b) => (a.counters.shots ?? 0) - (b.counters.shots ?? 0) || newest(a, b),
};

function hitsOf(one: LibraryEntry): number {
  return one.targets ?? one.hits.length;
}

function oneOf<T extends string>(known: readonly T[], text: string | null): T | null {
  return known.find((one) => one === text) ?? null;
}

function wholeNumber(text: string | null): number | null {
  return text !== null && /^\d{1,3}$/.test(text) ? Number(text) : null;
}
