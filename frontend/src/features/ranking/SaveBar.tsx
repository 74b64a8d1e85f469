import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { ReactNode } from "react";

import { isPassing, messageOf } from "@/api/client";
import { Button, IconButton } from "@/components/controls/Button";
import { Notice } from "@/components/feedback/States";
import type { RankingSaver, SaverState } from "@/features/ranking/order/saver";

import styles from "./SaveBar.module.css";

/** Whether the order is saved, with what changes all of it, and what comes next. */
export function SaveBar({
  state,
  saver,
  onStep,
  onTurnRound,
  children,
}: {
  state: SaverState;
  saver: RankingSaver;
  onStep: (step: "undo" | "redo") => void;
  /** Makes the worst the best. */
  onTurnRound: () => void;
  children: ReactNode;
}) {
  const { saved, saving, error, conflict } = state;
  return (
    <>
      <div className={styles.bar}>
        <h2>
          <Trans>Best to worst</Trans>
        </h2>
        <span className={styles.saved} role="status">
          {saving ? t`Saving…` : error ? t`Not saved` : t`Saved`}
        </span>
        <IconButton
          icon="undo"
          label={t`Undo (Ctrl+Z)`}
          // Disabled after the last undo, it would lose the focus.
          aria-disabled={!saved.can_undo || conflict !== null}
          onClick={() => onStep("undo")}
        />
        <IconButton
          icon="redo"
          label={t`Redo (Ctrl+Shift+Z)`}
          aria-disabled={!saved.can_redo || conflict !== null}
          onClick={() => onStep("redo")}
        />
        <IconButton
          icon="turnRound"
          label={t`Reverse the order`}
          disabled={state.tiers.length < 2 || conflict !== null}
          onClick={onTurnRound}
        />
        {children}
      </div>
      {error !== null && <SaveError error={error} saver={saver} />}
    </>
  );
}

/** Why the order could not be saved. */
export function SaveError({ error, saver }: { error: unknown; saver: RankingSaver }) {
  return (
    <Notice tone="bad" live>
      <p>
        <Trans>The order could not be saved: {messageOf(error)}</Trans>
        {isPassing(error) && (
          <>
            {" "}
            <Trans>Tril tries again by itself, also while you look at other pages.</Trans>
          </>
        )}
      </p>
      <Button onClick={() => saver.retry()}>
        <Trans>Try again</Trans>
      </Button>
      {!isPassing(error) && (
        <Button onClick={() => saver.giveUp()}>
          <Trans>Back to the saved order</Trans>
        </Button>
      )}
    </Notice>
  );
}
