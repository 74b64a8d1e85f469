import { plural, t } from "@lingui/core/macro";
import type { RefObject } from "react";

import type { Behaviour } from "@/api/types";
import type { HitAt } from "@/features/play/stream/text-messages";
import { useGame } from "@/games/game";
import { fixed } from "@/lib/format";
import { gridState, type ItemGridSize, takenCells } from "@/lib/game/items";

import styles from "./StageHud.module.css";

interface StageHudProps {
  /** Where the clock writes the seconds left. */
  time: RefObject<HTMLSpanElement | null>;
  hits: readonly HitAt[];
  behaviour: Behaviour;
}

/** Time, targets and strays over the picture, where it fills the screen and hides all else. */
export function StageHud({ time, hits, behaviour: { target } }: StageHudProps) {
  const game = useGame();
  return (
    // The same stands beside the picture, in words for screen readers.
    <div className={styles.hud} aria-hidden="true">
      <span>
        <span ref={time}>
          {fixed((game.max_steps * game.frames_per_step) / game.frame_rate_hz, 1)}
        </span>{" "}
        s
      </span>
      {game.items && target && <span>{takenWords(game.items, hits, target)}</span>}
    </div>
  );
}

function takenWords(
  size: ItemGridSize,
  hits: readonly HitAt[],
  target: NonNullable<Behaviour["target"]>,
): string {
  const { hit, stray } = gridState(size, takenCells({ hits }), target);
  const targets = plural(target.length, { one: "# target", other: "# targets" });
  return t`${hit.length} of ${targets}, ${plural(stray.length, { one: "# stray", other: "# strays" })}`;
}
