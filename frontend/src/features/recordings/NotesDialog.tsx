import type { Recording } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
import { useDraft } from "@/components/controls/drafts";
import { Field } from "@/components/controls/Field";
import { recordingName } from "@/lib/recordings";

import styles from "./NotesDialog.module.css";

const MOST_CHARACTERS = 4000;

/** Edits the note on a recording. */
export function NotesDialog({
  recording,
  onSave,
  onClose,
}: {
  recording: Recording;
  onSave: (notes: string) => void;
  onClose: () => void;
}) {
  const notes = useDraft(`note ${recording.id}`, recording.notes);
  return (
    <Dialog title={`Note on ${recordingName(recording).toLowerCase()}`} onClose={onClose}>
      <form
        className={styles.form}
        onSubmit={(event) => {
          event.preventDefault();
          onSave(notes.value.trim());
          notes.drop();
          onClose();
        }}
      >
        <Field label="Note">
          {(control) => (
            <textarea
              {...control}
              rows={5}
              value={notes.value}
              maxLength={MOST_CHARACTERS}
              onChange={(event) => notes.set(event.currentTarget.value)}
            />
          )}
        </Field>
        <div className={styles.actions}>
          <Button kind="primary" type="submit">
            Save note
          </Button>
          <Button
            kind="quiet"
            onClick={() => {
              notes.drop();
              onClose();
            }}
          >
            Cancel
          </Button>
        </div>
      </form>
    </Dialog>
  );
}
