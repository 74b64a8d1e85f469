import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useMutation } from "@tanstack/react-query";

import { messageOf } from "@/api/client";
import { fetchArchive } from "@/api/runs";
import type { Behaviour, Run } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Notice } from "@/components/feedback/States";
import { saveFile } from "@/lib/browser/save-file";

import styles from "./TakeAway.module.css";

/** Downloads a finished run as one zip. */
export function TakeAway({ run, behaviour }: { run: Run; behaviour: Behaviour }) {
  const download = useMutation({
    mutationFn: () => fetchArchive(run.id),
    onSuccess: (archive) => saveFile(archive, `tril-${behaviour.slug}-${run.id.slice(0, 8)}.zip`),
  });
  return (
    <div className={styles.takeAway}>
      <p>
        <Trans>
          One zip with a report that opens anywhere, the policies and the reward as files that load
          without Tril, all games, curves and hyperparameters. <code>tril runs import</code> reads
          it again, on any machine.
        </Trans>
      </p>
      <Button icon="download" disabled={download.isPending} onClick={() => download.mutate()}>
        {download.isPending ? t`Making the zip…` : t`Everything as a zip`}
      </Button>
      <p className={styles.hint} role="status">
        {download.isPending && t`Figures and clips are drawn; this takes up to a minute.`}
      </p>
      {download.error && (
        <Notice tone="bad" live>
          <p>{messageOf(download.error)}</p>
        </Notice>
      )}
    </div>
  );
}
