/** The data of the plot of predicted return against the worth of games. */

import { t } from "@lingui/core/macro";

import type { JudgedGames } from "@/api/types";
import { measured } from "@/lib/format";
import { recordingName } from "@/lib/recordings";

import type { ScatterPoint } from "./ScatterPlot";

/** Total horizontal offset, in targets, between the groups at one worth. */
const APART = 0.5;

/** Returns a mark for each game, offset by group so that equal worths do not overlap. */
export function marksOf(groups: readonly JudgedGames[]): readonly ScatterPoint[] {
  return groups.flatMap(({ player, demonstrated, games }, place) => {
    const shift = (APART * (place - (groups.length - 1) / 2)) / groups.length;
    return games.map((game) => ({
      key: `${player}-${String(demonstrated)}-${game.recording_id}`,
      x: game.true_quantity + shift,
      y: game.predicted_return,
      thing: player,
      hollow: !demonstrated,
      title:
        t`${recordingName({ id: game.recording_id })}, worth ${game.true_quantity}: ` +
        measured(game.predicted_return),
    }));
  });
}

interface Bounds {
  readonly low: number;
  readonly high: number;
}

/** Returns the range of the games' worth; null without games. */
export function worthOf(groups: readonly JudgedGames[]): Bounds | null {
  return boundsOf(groups.flatMap(({ games }) => games.map((game) => game.true_quantity)));
}

/** Returns the range of the games' predicted returns; null without games. */
export function returnOf(groups: readonly JudgedGames[]): Bounds | null {
  return boundsOf(groups.flatMap(({ games }) => games.map((game) => game.predicted_return)));
}

function boundsOf(values: readonly number[]): Bounds | null {
  return values.length === 0 ? null : { low: Math.min(...values), high: Math.max(...values) };
}
