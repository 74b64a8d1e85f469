import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import { messageOf } from "@/api/client";
import type { Behaviour } from "@/api/types";
import { viewOf } from "@/games/views";

import styles from "./OpinionBar.module.css";
import type { Opinions } from "./use-opinions";

interface OpinionBarProps {
  behaviour: Behaviour;
  opinions: Opinions;
  shown: boolean;
  onShow: (shown: boolean) => void;
}

/** Shows what the ranking asks for and what the marks beside the games mean, and hides both. */
export function OpinionBar({ behaviour, opinions, shown, onShow }: OpinionBarProps) {
  const Wanted = viewOf(behaviour.game)?.Wanted;
  const missing = whyMissing(opinions);
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
      {shown && opinions.answer?.wanted && Wanted && (
        <Wanted
          title={t`What this order asks for`}
          inferred={opinions.answer.wanted}
          behaviour={behaviour}
          scale={2}
        >
          <p>
            <Trans>
              The mark on a game&rsquo;s bar, from best to worst, shows where the other games would
              place it by what it hits. A wide band means unsure.
            </Trans>
          </p>
        </Wanted>
      )}
      {shown && missing !== null && <p>{missing}</p>}
    </div>
  );
}

/** Returns why there is nothing to show, or nothing new; null if there is. */
function whyMissing({ answer, error }: Opinions): string | null {
  if (error !== null) return t`It could not be worked out: ${messageOf(error)}`;
  if (!answer) return t`Working it out…`;
  if (answer.wanted) return null;
  return t`Rank four games in at least two tiers to see what they ask for, and where they suggest that each game belongs.`;
}
