import { Trans } from "@lingui/react/macro";

import type { Behaviour } from "@/api/types";
import { ItemGrid } from "@/components/game/ItemGrid";
import type { HitAt } from "@/features/play/stream/text-messages";
import { useGame } from "@/games/game";
import { wordsOf } from "@/games/words";
import { gridState } from "@/lib/game/items";

import styles from "./Score.module.css";

/** The items taken so far, on and off target; nothing for a game without items. */
export function Score({ hits, behaviour }: { hits: readonly HitAt[]; behaviour: Behaviour }) {
  const game = useGame();
  if (!game.items) return null;
  const cells = hits.map(({ row, column }) => [row, column] as const);
  const { hit, stray } = gridState(game.items, cells, behaviour.target);
  return (
    <div className={styles.score}>
      <ItemGrid hits={cells} target={behaviour.target} scale={2} />
      <dl>
        {behaviour.target ? (
          <>
            <div>
              <dt>
                <Trans>Targets hit</Trans>
              </dt>
              <dd>
                {hit.length}{" "}
                <small>
                  <Trans>of {behaviour.target.length}</Trans>
                </small>
              </dd>
            </div>
            <div>
              <dt>
                <Trans>Strays</Trans>
              </dt>
              <dd>{stray.length}</dd>
            </div>
          </>
        ) : (
          <div>
            <dt>{wordsOf(game).takenTitle()}</dt>
            <dd>{hits.length}</dd>
          </div>
        )}
      </dl>
    </div>
  );
}
