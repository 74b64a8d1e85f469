import { Trans } from "@lingui/react/macro";

import type { Behaviour } from "@/api/types";
import { ItemGrid } from "@/components/game/ItemGrid";
import type { HitAt } from "@/features/play/stream/text-messages";
import { useGame } from "@/games/game";
import { gridState } from "@/lib/game/items";

import styles from "./Score.module.css";

/** The items taken so far, on and off target; nothing without a target. */
export function Score({ hits, behaviour }: { hits: readonly HitAt[]; behaviour: Behaviour }) {
  const game = useGame();
  const { target } = behaviour;
  if (!game.items || !target) return null;
  const cells = hits.map(({ row, column }) => [row, column] as const);
  const { hit, stray } = gridState(game.items, cells, target);
  return (
    <div className={styles.score}>
      <ItemGrid hits={cells} target={target} scale={2} />
      <dl>
        <div>
          <dt>
            <Trans>Targets hit</Trans>
          </dt>
          <dd>
            {hit.length}{" "}
            <small>
              <Trans>of {target.length}</Trans>
            </small>
          </dd>
        </div>
        <div>
          <dt>
            <Trans>Strays</Trans>
          </dt>
          <dd>{stray.length}</dd>
        </div>
      </dl>
    </div>
  );
}
