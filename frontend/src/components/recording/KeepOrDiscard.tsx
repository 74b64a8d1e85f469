import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { Recording } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { isEmpty, isUndecided, recordingName, whyUnrankable } from "@/lib/recordings";

import styles from "./KeepOrDiscard.module.css";
import { useRecordingActions } from "./use-recording-actions";

/** Says why a recording can't be ranked, and asks whether to keep a game that isn't kept yet. */
export function KeepOrDiscard({ recording }: { recording: Recording }) {
  const { keep, remove } = useRecordingActions(recording.behaviour_id);
  const why = whyUnrankable(recording);
  if (why === null || recording.deleted) return null;
  const name = recordingName(recording);
  const replays = recording.verification !== "failed";
  const empty = isEmpty(recording);
  return (
    <div className={styles.prompt}>
      <p>{why}</p>
      {recording.state !== "kept" && (
        <div className={styles.buttons}>
          {!empty && (replays || isUndecided(recording)) && (
            <Button
              kind={isUndecided(recording) ? "primary" : "secondary"}
              aria-label={t`Keep ${name}`}
              onClick={() => keep(recording)}
            >
              <Trans>Keep</Trans>
            </Button>
          )}
          {(empty || isUndecided(recording)) && (
            <Button aria-label={t`Discard ${name}`} onClick={() => remove(recording)}>
              <Trans>Discard</Trans>
            </Button>
          )}
        </div>
      )}
    </div>
  );
}
