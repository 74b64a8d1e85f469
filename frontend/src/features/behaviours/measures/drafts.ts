/** Measures as a form has them: which kinds a game allows, and what a new one begins with. */
import type { Measure, TaughtGame } from "@/api/types";
import { countersOf } from "@/games/measures";
import { allCells, type Cell } from "@/lib/game/items";

export type Kind = Measure["kind"];

/** As the server has it. */
export const MOST_MEASURES = 12;
const MOST_GROUPS = 24;

/** Returns the kinds of measures that a game allows. */
export function kindsOf(game: TaughtGame): readonly Kind[] {
  const nThings = Object.keys(game.things).length;
  const kinds: readonly (readonly [Kind, boolean])[] = [
    ["region", nThings > 0],
    ["nearness", nThings > 1],
    ["items", game.items !== null],
    ["order", orders(game).length > 0],
    ["rate", game.buttons.length > 0],
    ["counter", countersOf(game).length > 0],
    ["score", true],
    ["alive", true],
    ["length", true],
  ];
  return kinds.filter(([, allowed]) => allowed).map(([kind]) => kind);
}

/** Returns what a new measure of a kind begins with. */
export function newMeasure(kind: Kind, game: TaughtGame): Measure {
  const [first = "", second = ""] = Object.keys(game.things);
  const { width, height } = game;
  switch (kind) {
    case "region":
      return { kind, thing: first, area: [0, 0, Math.floor(width / 2), height], at_least: 0.9 };
    case "nearness":
      return { kind, thing: first, other: second, distance_px: 16, axes: "both", at_least: 0.5 };
    case "items":
      return { kind, at_least: 1 };
    case "order":
      return { kind, sequences: orders(game)[0]?.sequences ?? [], at_least: 0.9 };
    case "rate":
      return { kind, button: game.buttons.at(-1) ?? null, per: "second", at_most: 1 };
    case "counter":
      return { kind, counter: countersOf(game)[0]?.[0] ?? null, at_least: 1 };
    case "score":
      return { kind, at_least: 100 };
    case "alive":
      return { kind };
    case "length":
      return { kind, at_least: 10 };
  }
}

export type OrderName = "rows-up" | "rows-down" | "left" | "right" | "outside" | "inside";
type Sequences = NonNullable<Measure["sequences"]>;

interface Order {
  readonly name: OrderName;
  readonly sequences: Sequences;
}

/** Returns the orders that can be chosen in a game with items. */
export function orders({ items }: TaughtGame): readonly Order[] {
  if (!items) return [];
  const group = (among: (cell: Cell) => boolean) =>
    allCells(items)
      .filter(among)
      .map(([row, column]): [number, number] => [row, column]);
  const rows = Array.from({ length: items.rows }, (_, row) => group((cell) => cell[0] === row));
  const columns = Array.from({ length: items.columns }, (_, column) =>
    group((cell) => cell[1] === column),
  );
  const middle = Math.floor(items.columns / 2);
  const left = columns.slice(0, middle);
  const right = columns.slice(middle);
  const all: readonly Order[] = [
    { name: "rows-up", sequences: [rows] },
    { name: "rows-down", sequences: [rows.toReversed()] },
    { name: "left", sequences: [columns] },
    { name: "right", sequences: [columns.toReversed()] },
    { name: "outside", sequences: [left, right.toReversed()] },
    { name: "inside", sequences: [left.toReversed(), right] },
  ];
  return all.filter(({ sequences }) => sequences.every((groups) => groups.length <= MOST_GROUPS));
}

/** Returns the name of the order that a measure has; null for another one. */
export function orderOf(sequences: Measure["sequences"], game: TaughtGame): OrderName | null {
  const sorted = (given: Sequences) =>
    JSON.stringify(given.map((groups) => groups.map((cells) => cells.map(String).sort())).sort());
  const wanted = sorted(sequences ?? []);
  return orders(game).find((order) => sorted(order.sequences) === wanted)?.name ?? null;
}
