import { isPassing, messageOf } from "@/api/client";
import { Button, IconButton } from "@/components/controls/Button";
import { Notice } from "@/components/feedback/States";
import type { RankingSaver, SaverState } from "@/features/ranking/order/saver";

import styles from "./SaveBar.module.css";

/** Whether the order is saved, with undo and redo. */
export function SaveBar({ state, saver }: { state: SaverState; saver: RankingSaver }) {
  const { saved, saving, error, conflict } = state;
  return (
    <>
      <div className={styles.bar}>
        <h2>Best to worst</h2>
        <span className={styles.saved} role="status">
          {saving ? "Saving…" : error ? "Not saved" : "Saved"}
        </span>
        <IconButton
          icon="undo"
          label="Undo (Ctrl+Z)"
          disabled={!saved.can_undo || conflict !== null}
          onClick={() => void saver.step("undo")}
        />
        <IconButton
          icon="redo"
          label="Redo (Ctrl+Shift+Z)"
          disabled={!saved.can_redo || conflict !== null}
          onClick={() => void saver.step("redo")}
        />
      </div>
      {error !== null && (
        <Notice tone="bad" live>
          <p>
            The order could not be saved: {messageOf(error)}
            {isPassing(error) && " Tril tries again by itself; your order stays on this page."}
          </p>
          <Button onClick={() => saver.retry()}>Try again</Button>
        </Notice>
      )}
    </>
  );
}
