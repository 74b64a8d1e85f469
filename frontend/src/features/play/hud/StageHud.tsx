import { plural, t } from "@lingui/core/macro";
import type { RefObject } from "react";

import type { Behaviour } from "@/api/types";
import type { HitAt } from "@/features/play/stream/text-messages";
import { FRAME_RATE_HZ, FRAMES_PER_STEP, MAX_STEPS } from "@/lib/format";
import { gridState } from "@/lib/game/aliens";

import styles from "./StageHud.module.css";

interface StageHudProps {
  /** Where the clock writes the seconds left. */
  time: RefObject<HTMLSpanElement | null>;
  hits: readonly HitAt[];
  behaviour: Behaviour;
}

/** Time, targets and strays over the picture, where it fills the screen and hides all else. */
export function StageHud({ time, hits, behaviour: { target } }: StageHudProps) {
  const cells = hits.map(({ row, column }) => [row, column] as const);
  const { hit, stray } = gridState(cells, target);
  return (
    // The same stands beside the picture, in words for screen readers.
    <div className={styles.hud} aria-hidden="true">
      <span>
        <span ref={time}>{(MAX_STEPS * FRAMES_PER_STEP) / FRAME_RATE_HZ}.0</span> s
      </span>
      <span>
        {target
          ? t`${hit.length} of ${plural(target.length, { one: "# target", other: "# targets" })}, ${plural(stray.length, { one: "# stray", other: "# strays" })}`
          : plural(hits.length, { one: "# alien hit", other: "# aliens hit" })}
      </span>
    </div>
  );
}
