/** Names of measures, their bounds and their values, in the page's language. */
import { plural, t } from "@lingui/core/macro";

import type { Measure, MeasuredValue, TaughtGame } from "@/api/types";
import { fixed, measured, NONE, percent, seconds, whole } from "@/lib/format";

import { buttonName } from "./actions";
import { capitalised, wordsOf } from "./words";

export type Unit = MeasuredValue["unit"];

/** Things and counts of games without a view, by what the server calls them. */
const titles = (): Readonly<Record<string, string>> => ({
  ball: t`ball`,
  "black boxer": t`black boxer`,
  "blue ghost": t`blue ghost`,
  chicken: t`chicken`,
  "divers picked up": t`divers picked up`,
  "green paddle": t`green paddle`,
  "orange ghost": t`orange ghost`,
  "orange paddle": t`orange paddle`,
  paddle: t`paddle`,
  "pink ghost": t`pink ghost`,
  plane: t`plane`,
  "red ghost": t`red ghost`,
  skier: t`skier`,
  submarine: t`submarine`,
  "white boxer": t`white boxer`,
});

function translated(title: string, game: TaughtGame): string {
  const known = { ...titles(), ...wordsOf(game).titles() };
  return Object.hasOwn(known, title) ? (known[title] ?? title) : title;
}

/** Names a thing of a game, within a sentence: "ball". */
export function thingTitle(name: string, game: TaughtGame): string {
  return translated(game.things[name] ?? name, game);
}

/** Returns what can be counted in a game, by name, with its title. */
export function countersOf(game: TaughtGame): readonly (readonly [string, string])[] {
  return Object.entries({ ...game.counters, ...game.tallies }).map(([name, title]) => [
    name,
    translated(title, game),
  ]);
}

/** Returns what the values of a measure are counted in. */
export function unitOf({ kind, per }: Measure): Unit {
  switch (kind) {
    case "items":
      return "items";
    case "order":
    case "region":
    case "nearness":
      return "share";
    case "rate":
      return per === "time" ? "share" : "per_second";
    case "score":
      return "points";
    case "alive":
      return "yes";
    case "length":
      return "seconds";
    case "counter":
      return "count";
  }
}

/** Names what is measured: "Ball in the left 49% of the screen". */
export function measureName(measure: Measure, game: TaughtGame): string {
  switch (measure.kind) {
    case "items":
      return itemsName(measure, game);
    case "order":
      return t`Taken in their order`;
    case "region": {
      const thing = capitalised(thingTitle(measure.thing ?? "", game));
      return regionName(thing, measure.area ?? [0, 0, 0, 0], game);
    }
    case "nearness":
      return nearnessName(measure, game);
    case "rate":
      return rateName(measure);
    case "score":
      return t`Score`;
    case "alive":
      return t`Alive at the end`;
    case "length":
      return t`Length of the game`;
    case "counter": {
      const title = countersOf(game).find(([name]) => name === measure.counter)?.[1];
      return capitalised(title ?? measure.counter ?? "");
    }
  }
}

/** Says which part of the screen an area is where it ends at three edges, else its corners. */
function regionName(thing: string, area: readonly number[], game: TaughtGame): string {
  const [left = 0, top = 0, right = 0, bottom = 0] = area;
  const { width, height } = game;
  const high = top <= 0 && bottom >= height;
  const wide = left <= 0 && right >= width;
  const across = percent((right - left) / width, 0);
  const down = percent((bottom - top) / height, 0);
  if (high && !wide && left <= 0) return t`${thing} in the left ${across} of the screen`;
  if (high && !wide && right >= width) return t`${thing} in the right ${across} of the screen`;
  if (wide && !high && top <= 0) return t`${thing} in the upper ${down} of the screen`;
  if (wide && !high && bottom >= height) return t`${thing} in the lower ${down} of the screen`;
  return t`${thing} in the area ${left}, ${top} to ${right}, ${bottom}`;
}

function itemsName({ cells }: Measure, game: TaughtGame): string {
  const taken = wordsOf(game).takenTitle();
  if (!cells) return taken;
  const chosen = plural(cells.length, { one: "of # that counts", other: "of # that count" });
  return `${taken}, ${chosen}`;
}

function nearnessName({ thing, other, axes, distance_px: px }: Measure, game: TaughtGame): string {
  const first = capitalised(thingTitle(thing ?? "", game));
  const second = thingTitle(other ?? "", game);
  const distance = px ?? 0;
  if (axes === "x") return t`${first} and ${second} at most ${distance} px apart sideways`;
  if (axes === "y") return t`${first} and ${second} at most ${distance} px apart in height`;
  return t`${first} and ${second} at most ${distance} px apart`;
}

function rateName({ button, action, per }: Measure): string {
  const name = button ? t`Button “${buttonName(button)}”` : t`Action ${action ?? ""}`;
  return per === "time" ? t`${name} held` : t`${name} pressed`;
}

/** Writes a value in its unit: "90%", "1.5 a second". */
export function valueText(value: number, unit: Unit): string {
  switch (unit) {
    case "share":
      return t`${percent(value, 0)} of the time`;
    case "per_second":
      return t`${measured(value)} a second`;
    case "yes":
      return value > 0 ? t`yes` : t`no`;
    case "seconds":
      return seconds(value);
    case "points":
    case "items":
    case "count":
      return Number.isInteger(value) ? whole(value) : fixed(value, 1);
  }
}

/** Writes a value of a measure; shares of items are not of the time. */
export function measureValue(value: number, measure: Measure): string {
  return measure.kind === "order" ? percent(value, 0) : valueText(value, unitOf(measure));
}

/** Writes the mean of a measure over games: shares of games where it is yes or no. */
export function meanValue(mean: number, measure: Measure): string {
  if (measure.kind === "alive") return percent(mean, 0);
  const unit = unitOf(measure);
  return unit === "items" || unit === "count" || unit === "points"
    ? fixed(mean, 1)
    : measureValue(mean, measure);
}

/** Writes the bounds of a measure: "at least 90% of the time"; empty without any. */
export function boundText(measure: Measure): string {
  const { at_least: low, at_most: high } = measure;
  const lowest = low == null ? "" : measureValue(low, measure);
  const highest = high == null ? "" : measureValue(high, measure);
  if (low != null && high != null) return t`between ${lowest} and ${highest}`;
  if (low != null) return t`at least ${lowest}`;
  return high == null ? "" : t`at most ${highest}`;
}

/** Says what a measure asks for: "Score: at least 100". */
export function measureSentence(measure: Measure, game: TaughtGame): string {
  const name = measureName(measure, game);
  const bound = boundText(measure);
  return bound === "" ? name : `${name}: ${bound}`;
}

/** Writes what was measured in a game. */
export function measuredText({ value, known }: MeasuredValue, measure: Measure): string {
  if (!known) return t`being measured…`;
  return value === null ? NONE : measureValue(value, measure);
}

/** Says how many of a behaviour's measures with bounds a game meets; empty if there are none. */
export function metText(values: readonly MeasuredValue[], measures: readonly Measure[]): string {
  const asked = values.filter(
    (_, index) =>
      measures[index] && (measures[index].kind === "alive" || isBounded(measures[index])),
  );
  const met = asked.filter((one) => one.met === true).length;
  if (asked.length === 0) return "";
  if (asked.some(({ known }) => !known)) return t`being measured…`;
  return plural(asked.length, {
    one: `${met} of # measure met`,
    other: `${met} of # measures met`,
  });
}

function isBounded({ at_least: low, at_most: high }: Measure): boolean {
  return low != null || high != null;
}
