/** Formats numbers, times and sizes. */

import { plural, selectOrdinal, t } from "@lingui/core/macro";

import { i18n } from "./i18n";

/** Stands between a number and its unit, which a line break would part. */
const NO_BREAK_SPACE = "\u00a0";

/** Placeholder for a missing value. */
export const NONE = "–";

/** Formats an integer with the language's thousands separators. */
export function whole(n: number): string {
  return i18n.number(n, { maximumFractionDigits: 0 }).replace("-", "−");
}

function withUnit(figure: string | number, unit: string): string {
  return `${figure}${NO_BREAK_SPACE}${unit}`;
}

/** Writes a decimal number as the language does: "9,3" in German. */
function inLanguage(digits: string): string {
  return digits.replace(".", decimalSign()).replace("-", "−");
}

/** Returns the sign before the decimals: a comma in German. */
export function decimalSign(): string {
  return i18n.number(0.1).charAt(1);
}

/** Returns the sign between thousands: a point in German. */
export function thousandsSign(): string {
  return i18n.number(10_000).charAt(2);
}

/** Returns a noun as it is written within a sentence: in lower case, other than in German. */
export function inSentence(noun: string): string {
  if (i18n.locale === "de") return noun;
  return noun.charAt(0).toLowerCase() + noun.slice(1);
}

/** Joins names: "a and b". */
export function listed(names: readonly string[]): string {
  return names.reduce((before, last) => t`${before} and ${last}`);
}

/** Formats a number of steps compactly: "300 k", "10 M", "1,500". */
export function shortCount(n: number): string {
  if (n >= 1_000_000 && n % 100_000 === 0) return withUnit(trimmed(n / 1_000_000), "M");
  if (n >= 10_000 && n % 1_000 === 0) return withUnit(trimmed(n / 1_000), "k");
  return whole(n);
}

/** Formats the ticks of an axis with as many digits as their spacing needs. */
export function tickLabels(ticks: readonly number[]): string[] {
  const distance = Math.abs((ticks[1] ?? 0) - (ticks[0] ?? 0));
  const digits = distance > 0 ? digitsOf(distance) : 2;
  return ticks.map((tick) => (distance >= 1 ? whole(tick) : fixed(tick, digits)));
}

/** The digits after the point that multiples of a distance need: 1 for 0.2, 2 for 0.25. */
function digitsOf(distance: number): number {
  const enough = (digits: number) => {
    const scaled = distance * 10 ** digits;
    return Math.abs(scaled - Math.round(scaled)) < 1e-6 * scaled;
  };
  return [0, 1, 2, 3, 4, 5].find(enough) ?? 6;
}

/** Formats the ticks of an axis of steps, with the digits that tell them apart: "5 k", "1.25 M". */
export function stepLabels(ticks: readonly number[]): string[] {
  const distance = Math.abs((ticks[1] ?? 0) - (ticks[0] ?? 0));
  const inUnit = (tick: number, unit: number) =>
    trimmed(tick / unit, distance > 0 ? digitsOf(distance / unit) : 1);
  return ticks.map((tick) =>
    tick >= 1_000_000
      ? withUnit(inUnit(tick, 1_000_000), "M")
      : tick >= 1000
        ? withUnit(inUnit(tick, 1000), "k")
        : distance > 0 && distance < 1
          ? fixed(tick, digitsOf(distance))
          : whole(tick),
  );
}

/** Formats the ticks of an axis of shares, 0 to 1. */
export function percentLabels(ticks: readonly number[]): string[] {
  return ticks.map((tick) => percent(tick, 0));
}

function trimmed(n: number, digits = 1): string {
  const text = n.toFixed(digits);
  return inLanguage(digits > 0 ? text.replace(/\.?0+$/, "") : text);
}

/** Formats a number with a fixed number of decimals and a true minus sign. */
export function fixed(n: number, digits: number): string {
  const text = n.toFixed(digits);
  return inLanguage(Number(text) === 0 ? text.replace("-", "") : text);
}

/** Adds a standard deviation to a figure: "0.42 ± 0.08". */
export function withDeviation(figure: string, deviation: number | null | undefined): string {
  return deviation === null || deviation === undefined
    ? figure
    : `${figure} ± ${fixed(deviation, 2)}`;
}

/** Formats a measurement with about three significant digits. */
export function measured(n: number): string {
  if (!Number.isFinite(n)) return NONE;
  const size = Math.abs(n);
  if (size >= 1000) return whole(n);
  if (size >= 100) return fixed(n, 0);
  if (size >= 10) return fixed(n, 1);
  if (size >= 0.01 || size === 0) return fixed(n, 2);
  return inLanguage(n.toExponential(1).replaceAll("-", "−"));
}

/** Formats a share, 0 to 1, as a percentage: "98.4%". */
export function percent(share: number, digits = 1): string {
  return t`${fixed(share * 100, digits)}%`;
}

/** Formats progress, 0 to 1, which is 100% only once it is complete. */
export function percentDone(progress: number): string {
  return percent(Math.floor(progress * 100) / 100, 0);
}

export interface Interval {
  readonly mean: number;
  readonly low: number;
  readonly high: number;
  readonly n: number;
}

/** Formats the bounds of a 95% interval: "3.9 to 5.4". */
export function bounds({ low, high }: Interval, digits = 1): string {
  return t`${fixed(low, digits)} to ${fixed(high, digits)}`;
}

/** Formats the worth of games: "88%"; 0% where it is negative, less than that of a game that is over. */
export function wholeShare(share: number): string {
  return percent(Math.max(0, share), 0);
}

/** Formats seconds of play: "14.2 s". */
export function seconds(s: number, digits = 1): string {
  return withUnit(fixed(s, digits), "s");
}

/** Formats a duration in its largest units: "40 s", "17 min", "2 h 05 min". */
export function duration(s: number): string {
  if (s < 59.5) return withUnit(Math.max(0, Math.round(s)), "s");
  const minutes = Math.round(s / 60);
  if (minutes < 60) return withUnit(minutes, "min");
  const hours = Math.floor(minutes / 60);
  if (hours < 48) {
    const minutesLeft = String(minutes % 60).padStart(2, "0");
    return `${withUnit(hours, "h")} ${withUnit(minutesLeft, "min")}`;
  }
  return plural(Math.round(hours / 24), { one: "# day", other: "# days" });
}

/**
 * Formats the remaining time, "about 9 min left", in minutes, from ten on in fives, from an hour on
 * in quarters; empty if unknown.
 */
export function remaining(s: number | null): string {
  if (s === null) return "";
  if (s < 60) return t`less than a minute left`;
  const step = s < 600 ? 60 : s < 3600 ? 300 : 900;
  return t`about ${duration(Math.round(s / step) * step)} left`;
}

/** Formats bytes in decimal units: "1.5 kB", "14 MB". */
export function bytes(n: number): string {
  if (n < 1000) return withUnit(n, "B");
  const units = ["kB", "MB", "GB", "TB"];
  let size = n;
  let unit = -1;
  do {
    size /= 1000;
    unit += 1;
  } while (size >= 999.5 && unit < units.length - 1);
  return withUnit(fixed(size, size < 10 ? 1 : 0), units[unit] ?? "");
}

/** Formats a relative time: "just now", "5 min ago", "3 h ago", then the date. */
export function ago(time: string, now: number): string {
  const s = (now - new Date(time).getTime()) / 1000;
  if (s < 45) return t`just now`;
  if (s < 3600) return t`${Math.max(1, Math.round(s / 60))} min ago`;
  if (s < 86_400) return t`${Math.round(s / 3600)} h ago`;
  return new Date(time).toLocaleDateString(i18n.locale, {
    day: "numeric",
    month: "short",
    year: "numeric",
  });
}

/** Formats a date and time to the minute. */
export function moment(time: string): string {
  return new Date(time).toLocaleString(i18n.locale === "en" ? "en-GB" : i18n.locale, {
    day: "numeric",
    month: "short",
    year: "numeric",
    hour: "2-digit",
    minute: "2-digit",
  });
}

/** Formats an ordinal: 1st, 2nd, 3rd, 4th. */
export function ordinal(n: number): string {
  return selectOrdinal(n, { one: "#st", two: "#nd", few: "#rd", other: "#th" });
}
