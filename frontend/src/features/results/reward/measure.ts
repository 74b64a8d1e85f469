/** What of the reward a game is judged by. */

import { t } from "@lingui/core/macro";

import type { JudgedGames, RankingCheck } from "@/api/types";
import { fixed, measured } from "@/lib/format";

import { endTicks } from "./ticks";

export type Measure = JudgedGames["measure"];

export type RankedReturn = RankingCheck["returns"][number];

/** The final level, or the return in runs of earlier versions, which did not keep the level. */
export function measureOf(returns: RankingCheck["returns"]): Measure {
  const hasLevels = returns.length > 0 && returns.every((one) => one.final_level !== null);
  return hasLevels ? "final_level" : "predicted_return";
}

/** What a ranked game is judged by. */
export function judgedBy(measure: Measure, one: RankedReturn): number {
  return measure === "final_level" ? (one.final_level ?? 0) : one.predicted_return;
}

/**
 * @param isStatement Whether R is a statement, whose level adds up over a game.
 */
export function nameOf(measure: Measure, isStatement = false): string {
  if (isStatement && measure === "final_level") return t`Reached in all`;
  return measure === "final_level" ? t`Final level` : t`Predicted return`;
}

export function write(measure: Measure, value: number): string {
  return measure === "final_level" ? fixed(value, 2) : measured(value);
}

/** Ends of an axis with these values; that of final levels has 0 and 1, which mean something. */
export function rangeOf(measure: Measure, values: readonly number[]): [number, number] {
  if (measure !== "final_level") return [Math.min(...values), Math.max(...values)];
  const tenths = values.map((value) => Math.round(value * 10) / 10 || 0); // 0 for -0
  return [Math.min(0, ...tenths), Math.max(1, ...tenths)];
}

/** Ticks of that axis: its ends, and 0 and 1 of final levels, beside which no end has a tick. */
export function ticksOf(measure: Measure, low: number, high: number): number[] {
  if (measure !== "final_level") return endTicks(low, high);
  const apart = (high - low) / 10;
  const ends = [low, high].filter((end) => Math.min(Math.abs(end), Math.abs(end - 1)) > apart);
  return [...ends, 0, 1];
}
