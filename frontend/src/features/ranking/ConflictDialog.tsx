import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import { Button } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
import { movedBetween, type Tiers } from "@/features/ranking/order/order";
import { useRecordingName } from "@/features/ranking/recording-names";

import styles from "./ConflictDialog.module.css";

interface ConflictDialogProps {
  theirs: Tiers;
  mine: Tiers;
  onSettle: (whose: "theirs" | "mine") => void;
}

/** Shows two conflicting orders and lets the user choose. */
export function ConflictDialog({ theirs, mine, onSettle }: ConflictDialogProps) {
  const moved = movedBetween(theirs, mine);
  return (
    <Dialog title={t`The order was changed elsewhere`} width="44rem">
      <p className={styles.conflictWords}>
        <Trans>
          Another tab or person saved an order while you changed this one. Which one do you want to
          keep? If you use yours, undo still brings theirs back.
        </Trans>
      </p>
      <div className={styles.conflict}>
        <section aria-label={t`Saved elsewhere`}>
          <h3>
            <Trans>Saved elsewhere</Trans>
          </h3>
          <Order tiers={theirs} moved={moved} />
          <Button onClick={() => onSettle("theirs")}>
            <Trans>Keep theirs</Trans>
          </Button>
        </section>
        <section aria-label={t`Yours`}>
          <h3>
            <Trans>Yours</Trans>
          </h3>
          <Order tiers={mine} moved={moved} />
          <Button kind="primary" onClick={() => onSettle("mine")}>
            <Trans>Use mine</Trans>
          </Button>
        </section>
      </div>
    </Dialog>
  );
}

function Order({ tiers, moved }: { tiers: Tiers; moved: ReadonlySet<number> }) {
  const nameOf = useRecordingName();
  if (tiers.length === 0)
    return (
      <p>
        <Trans>Nothing is ranked.</Trans>
      </p>
    );
  return (
    <ol>
      {tiers.map((tier, index) => (
        <li key={tier.join("-")}>
          <span>{index + 1}</span>
          <span>
            {tier.map((id, place) => (
              <span key={id}>
                {place > 0 && " = "}
                <span className={moved.has(id) ? styles.moved : undefined}>{nameOf(id)}</span>
              </span>
            ))}
          </span>
        </li>
      ))}
    </ol>
  );
}
