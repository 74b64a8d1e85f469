/** The data of the plot of what the reward predicts against the worth of games. */

import { t } from "@lingui/core/macro";

import type { JudgedGames } from "@/api/types";
import { actorNames } from "@/lib/actors";

import { write } from "./measure";
import type { ScatterPoint } from "./ScatterPlot";

/** Total horizontal offset, in targets, between the groups at one worth. */
const APART = 0.5;

/** Returns a mark for each game, offset by group so that equal worths do not overlap. */
export function marksOf(groups: readonly JudgedGames[]): readonly ScatterPoint[] {
  return groups.flatMap(({ player, demonstrated, measure, games }, place) => {
    const shift = (APART * (place - (groups.length - 1) / 2)) / groups.length;
    return games.map((game) => ({
      key: `${player}-${String(demonstrated)}-${game.recording_id}`,
      x: game.true_quantity + shift,
      y: game.predicted,
      actor: player,
      hollow: !demonstrated,
      title:
        t`${actorNames()[player]}, worth ${game.true_quantity}: ` + write(measure, game.predicted),
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

/** Returns the range of what the reward predicts of the games; null without games. */
export function predictedOf(groups: readonly JudgedGames[]): Bounds | null {
  return boundsOf(groups.flatMap(({ games }) => games.map((game) => game.predicted)));
}

function boundsOf(values: readonly number[]): Bounds | null {
  return values.length === 0 ? null : { low: Math.min(...values), high: Math.max(...values) };
}
