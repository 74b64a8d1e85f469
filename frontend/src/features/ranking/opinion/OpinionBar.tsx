import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import { messageOf } from "@/api/client";

import styles from "./OpinionBar.module.css";
import type { Opinions } from "./use-opinions";

interface OpinionBarProps {
  opinions: Opinions;
  shown: boolean;
  onShow: (shown: boolean) => void;
}

/** Says what the marks beside the games mean, and hides them. */
export function OpinionBar({ opinions, shown, onShow }: OpinionBarProps) {
  return (
    <div className={styles.bar}>
      <label>
        <input
          type="checkbox"
          checked={shown}
          onChange={(event) => onShow(event.currentTarget.checked)}
        />
        <Trans>Show what the other games suggest</Trans>
      </label>
      {shown && <p>{legend(opinions)}</p>}
    </div>
  );
}

function legend({ answer, error }: Opinions): string {
  if (error !== null) return t`It could not be worked out: ${messageOf(error)}`;
  if (!answer) return t`Working it out…`;
  if (answer.needs_more)
    return t`Rank four games in at least two tiers to see where they suggest that each game belongs.`;
  if (answer.missing > 0)
    return plural(answer.missing, {
      one: "Looking at how # more game ends…",
      other: "Looking at how # more games end…",
    });
  return t`The bar beside a game runs from best to worst. Its mark shows where Tril would put this game, judging by how your other games end. A wide band means that it is unsure.`;
}
