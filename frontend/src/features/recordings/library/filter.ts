/** Which recordings the library shows, in which order, and how an address says so. */
import type { Recording } from "@/api/types";

export const SHOWN = ["all", "perfect", "ranked", "unranked", "deleted"] as const;
export const SOURCES = ["person", "scripted", "policy"] as const;
export const VERIFIED = ["yes", "no"] as const;
export const ORDERS = ["newest", "oldest", "targets", "strays", "longest", "shots"] as const;

export interface Filter {
  readonly show: (typeof SHOWN)[number];
  readonly source: (typeof SOURCES)[number] | null;
  readonly player: string | null;
  readonly verified: (typeof VERIFIED)[number] | null;
  /** At least so many targets hit; aliens, where there is no target. */
  readonly hits: number | null;
  /** At most so many strays. */
  readonly strays: number | null;
  readonly order: (typeof ORDERS)[number];
}

export const EVERYTHING: Filter = {
  show: "all",
  source: null,
  player: null,
  verified: null,
  hits: null,
  strays: null,
  order: "newest",
};

/** What an address asks for; what makes no sense in it is passed over. */
export function readFilter(search: URLSearchParams): Filter {
  return {
    show: oneOf(SHOWN, search.get("show")) ?? EVERYTHING.show,
    source: oneOf(SOURCES, search.get("source")),
    player: search.get("player"),
    verified: oneOf(VERIFIED, search.get("verified")),
    hits: wholeNumber(search.get("hits")),
    strays: wholeNumber(search.get("strays")),
    order: oneOf(ORDERS, search.get("order")) ?? EVERYTHING.order,
  };
}

/** An address's part for a filter; what is as usual is left out. */
export function writeFilter(filter: Filter): URLSearchParams {
  const search = new URLSearchParams();
  for (const key of Object.keys(EVERYTHING) as (keyof Filter)[]) {
    const value = filter[key];
    if (value !== null && value !== EVERYTHING[key]) search.set(key, String(value));
  }
  return search;
}

/** Whether something is left out, however the rest is ordered. */
export function isNarrow(filter: Filter): boolean {
  return writeFilter({ ...filter, order: EVERYTHING.order }).size > 0;
}

/** The recordings that a filter lets through, in its order. */
export function chosen(recordings: readonly Recording[], filter: Filter): Recording[] {
  return recordings.filter((one) => fits(one, filter)).sort(COMPARE[filter.order]);
}

function fits(one: Recording, filter: Filter): boolean {
  const { source, player, verified, hits, strays } = filter;
  return (
    SHOWS[filter.show](one) &&
    (source === null || one.source === source) &&
    (player === null || one.player === player) &&
    (verified === null || (one.verification === "verified") === (verified === "yes")) &&
    (hits === null || hitsOf(one) >= hits) &&
    (strays === null || (one.strays ?? 0) <= strays)
  );
}

const SHOWS: Readonly<Record<Filter["show"], (one: Recording) => boolean>> = {
  all: (one) => !one.deleted,
  perfect: (one) => !one.deleted && one.perfect,
  ranked: (one) => !one.deleted && one.ranked,
  unranked: (one) => !one.deleted && !one.ranked,
  deleted: (one) => one.deleted,
};

type Compare = (a: Recording, b: Recording) => number;

const newest: Compare = (a, b) => b.id - a.id;
const COMPARE: Readonly<Record<Filter["order"], Compare>> = {
  newest,
  oldest: (a, b) => a.id - b.id,
  targets: (a, b) => hitsOf(b) - hitsOf(a) || (a.strays ?? 0) - (b.strays ?? 0) || newest(a, b),
  strays: (a, b) => (a.strays ?? 0) - (b.strays ?? 0) || hitsOf(b) - hitsOf(a) || newest(a, b),
  longest: (a, b) => b.n_frames - a.n_frames || newest(a, b),
  shots: (a, b) => a.shots - b.shots || newest(a, b),
};

function hitsOf(one: Recording): number {
  return one.targets ?? one.hits.length;
}

function oneOf<T extends string>(known: readonly T[], text: string | null): T | null {
  return known.find((one) => one === text) ?? null;
}

function wholeNumber(text: string | null): number | null {
  return text !== null && /^\d{1,3}$/.test(text) ? Number(text) : null;
}
