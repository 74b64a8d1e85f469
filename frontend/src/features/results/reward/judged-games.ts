/** What the plot of predicted returns against the worth of games shows. Pure. */
import type { JudgedGames } from "@/api/types";
import { measured } from "@/lib/format";
import { recordingName } from "@/lib/recordings";

import type { ScatterPoint } from "./ScatterPlot";

/** How far apart, in targets, the marks of all who played stand at one worth. */
const APART = 0.5;

/** A mark for each game; those of one worth stand apart by who played. */
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
        `${recordingName({ id: game.recording_id })}, worth ${game.true_quantity}: ` +
        measured(game.predicted_return),
    }));
  });
}

export interface Bounds {
  readonly low: number;
  readonly high: number;
}

/** The least and the greatest worth of games; null without games. */
export function worthOf(groups: readonly JudgedGames[]): Bounds | null {
  return boundsOf(groups.flatMap(({ games }) => games.map((game) => game.true_quantity)));
}

/** The lowest and the highest predicted return of games; null without games. */
export function returnOf(groups: readonly JudgedGames[]): Bounds | null {
  return boundsOf(groups.flatMap(({ games }) => games.map((game) => game.predicted_return)));
}

function boundsOf(values: readonly number[]): Bounds | null {
  return values.length === 0 ? null : { low: Math.min(...values), high: Math.max(...values) };
}
