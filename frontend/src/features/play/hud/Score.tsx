import { Trans } from "@lingui/react/macro";

import type { Behaviour } from "@/api/types";
import { AlienGrid } from "@/components/game/AlienGrid";
import type { HitAt } from "@/features/play/stream/text-messages";
import { gridState } from "@/lib/game/aliens";

import styles from "./Score.module.css";

/** The hits so far, on and off target. */
export function Score({ hits, behaviour }: { hits: readonly HitAt[]; behaviour: Behaviour }) {
  const cells = hits.map(({ row, column }) => [row, column] as const);
  const { hit, stray } = gridState(cells, behaviour.target);
  return (
    <div className={styles.score}>
      <AlienGrid hits={cells} target={behaviour.target} scale={2} />
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
            <dt>
              <Trans>Aliens hit</Trans>
            </dt>
            <dd>{hits.length}</dd>
          </div>
        )}
      </dl>
    </div>
  );
}
