import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { memo, useState } from "react";
import { Link } from "react-router";

import { shownQuery } from "@/api/library";
import type { Behaviour, Recording } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Icon } from "@/components/controls/Icon";
import { Failed } from "@/components/feedback/States";
import { KeepOrDiscard } from "@/components/recording/KeepOrDiscard";
import { FilmStrip, LOOPS } from "@/components/recording/GamePicture";
import { SourceBadge } from "@/components/recording/SourceBadge";
import { usePerfectMark } from "@/components/recording/use-perfect-mark";
import { useRecordingActions } from "@/components/recording/use-recording-actions";
import { LatencyBadge, PaceBadge, VerifiedBadge } from "@/features/recordings/badges";
import { ColumnBars } from "@/features/recordings/ColumnBars";
import { NotesDialog } from "@/features/recordings/NotesDialog";
import { useGame } from "@/games/game";
import { describeCourse, describeResult } from "@/games/outcomes";
import { classes } from "@/lib/classes";
import { recordingName } from "@/lib/recordings";

import styles from "./RecordingCard.module.css";

interface ShownRecordingProps {
  recordingId: number;
  behaviour: Behaviour;
  onWatch: (recording: Recording) => void;
  selected: boolean;
  /** With `range`, the selection extends from the last card selected. */
  onSelect: (recordingId: number, range: boolean) => void;
}

/** A recording's card, once the recording is there. Memoized: others are selected beside it. */
export const ShownRecording = memo(function ShownRecording(props: ShownRecordingProps) {
  const { recordingId, behaviour } = props;
  const { data, error, refetch } = useQuery(shownQuery(behaviour.id, recordingId));
  if (data) return <RecordingCard {...props} recording={data} />;
  const name = recordingName(undefined);
  return (
    <div
      role="group"
      className={classes(styles.card, styles.missing)}
      aria-label={name}
      aria-busy={!error}
    >
      {error && <Failed what={name} error={error} onRetry={() => void refetch()} />}
    </div>
  );
});

/** A recording with its film strip, result and actions. */
function RecordingCard(props: ShownRecordingProps & { recording: Recording }) {
  const game = useGame();
  const { recording, behaviour, onWatch, selected, onSelect } = props;
  const name = recordingName(recording);
  const result = describeResult(recording, behaviour, game);
  return (
    <article
      className={classes(styles.card, selected && styles.selected)}
      aria-label={name}
      {...LOOPS}
    >
      <button
        type="button"
        className={styles.screen}
        aria-label={t`Watch ${name}`}
        onClick={() => onWatch(recording)}
      >
        <FilmStrip recording={recording} />
      </button>
      <div className={styles.facts}>
        <div className={styles.title}>
          <input
            type="checkbox"
            className={styles.select}
            aria-label={t`Select ${name}`}
            checked={selected}
            onChange={(event) =>
              onSelect(
                recording.id,
                event.nativeEvent instanceof MouseEvent && event.nativeEvent.shiftKey,
              )
            }
          />
          <h3>
            <Link to={`/recordings/${recording.id}`}>{name}</Link>
          </h3>
          <SourceBadge recording={recording} />
        </div>
        <div className={styles.row}>
          <div className={styles.words}>
            {result && <strong>{result}</strong>}
            <span>{describeCourse(recording, game)}</span>
          </div>
          <ColumnBars counts={recording.hits_per_column} target={behaviour.target} />
        </div>
        <div className={styles.badges}>
          <VerifiedBadge recording={recording} />
          <PaceBadge recording={recording} />
          <LatencyBadge recording={recording} />
        </div>
        <KeepOrDiscard recording={recording} />
        {recording.notes && <p className={styles.note}>{recording.notes}</p>}
        <Actions recording={recording} behaviour={behaviour} name={name} />
      </div>
    </article>
  );
}

/** The actions on a recording; a deleted one can only be restored. */
function Actions({
  recording,
  behaviour,
  name,
}: {
  recording: Recording;
  behaviour: Behaviour;
  name: string;
}) {
  const [writing, setWriting] = useState(false);
  const { mark, question } = usePerfectMark(behaviour);
  const actions = useRecordingActions(recording.behaviour_id);
  if (recording.deleted) {
    return (
      <div className={styles.actions}>
        <Button
          kind="quiet"
          icon="undo"
          aria-label={t`Restore ${name}`}
          onClick={() => actions.restore(recording)}
        >
          <Trans>Restore</Trans>
        </Button>
      </div>
    );
  }
  return (
    <div className={styles.actions}>
      <Button
        kind="quiet"
        aria-label={
          recording.perfect ? t`${name} is perfect. Remove the mark` : t`Mark ${name} as perfect`
        }
        aria-pressed={recording.perfect}
        onClick={() => {
          if (recording.perfect) actions.setPerfect(recording, false);
          else mark([recording], () => actions.setPerfect(recording, true));
        }}
      >
        <Icon name="star" filled={recording.perfect} />
        <Trans>Perfect</Trans>
      </Button>
      <Button
        kind="quiet"
        icon="note"
        aria-label={recording.notes ? t`Change the note` : t`Write a note`}
        onClick={() => setWriting(true)}
      >
        <Trans>Note</Trans>
      </Button>
      <Button
        kind="quiet"
        icon="trash"
        aria-label={t`Delete ${name}`}
        onClick={() => actions.remove(recording)}
      >
        <Trans>Delete</Trans>
      </Button>
      {question}
      {writing && (
        <NotesDialog
          recording={recording}
          onSave={(notes) => actions.setNotes(recording, notes)}
          onClose={() => setWriting(false)}
        />
      )}
    </div>
  );
}
