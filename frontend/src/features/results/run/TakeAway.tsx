import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import { messageOf } from "@/api/client";
import type { TakenAway } from "@/api/runs";
import type { Behaviour, Run } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Notice } from "@/components/feedback/States";
import { useTakingAway } from "@/features/results/use-taking-away";

import styles from "./TakeAway.module.css";

/** Downloads a finished run: as one page to send, or as one zip. */
export function TakeAway({ run, behaviour }: { run: Run; behaviour: Behaviour }) {
  const { mutate, isPending, variables, error } = useTakingAway(run, behaviour);
  const making = isPending ? variables : null;
  const save = (file: TakenAway) => ({
    // Disabled, the button that was pressed would lose the focus.
    "aria-disabled": isPending,
    onClick: () => {
      if (!isPending) mutate(file);
    },
  });
  return (
    <div className={styles.takeAway}>
      <p>
        <Trans>
          One page to send: a file that opens in any browser, without Tril and without a network.
          The imitator plays beside your best game, and your ranked games play, too. Its poster is a
          picture to send along.
        </Trans>
      </p>
      <div className={styles.buttons}>
        <Button icon="upload" {...save("page.html")}>
          {making === "page.html" ? t`Making the page…` : t`One page to send`}
        </Button>
        <Button icon="download" {...save("page.png")}>
          {making === "page.png" ? t`Making the poster…` : t`Its poster`}
        </Button>
      </div>
      <p>
        <Trans>
          One zip with a report that opens anywhere, imitator, clone and reward as files that load
          without Tril, all games, curves and hyperparameters. <code>tril runs import</code> reads
          it again, on any machine.
        </Trans>
      </p>
      <Button icon="download" {...save("archive.zip")}>
        {making === "archive.zip" ? t`Making the zip…` : t`Everything as a zip`}
      </Button>
      <p className={styles.hint} role="status">
        {making === "archive.zip" && t`Figures and clips are drawn; this takes up to a minute.`}
        {isPending &&
          making !== "archive.zip" &&
          t`The games are replayed first; this takes up to a minute.`}
      </p>
      {error && (
        <Notice tone="bad" live>
          <p>{messageOf(error)}</p>
        </Notice>
      )}
    </div>
  );
}
