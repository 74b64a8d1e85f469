import { useState } from "react";

import type { Recording } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
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
  const [notes, setNotes] = useState(recording.notes);
  return (
    <Dialog title={`Note on ${recordingName(recording).toLowerCase()}`} onClose={onClose}>
      <form
        className={styles.form}
        onSubmit={(event) => {
          event.preventDefault();
          onSave(notes.trim());
          onClose();
        }}
      >
        <Field label="Note">
          {(control) => (
            <textarea
              {...control}
              rows={5}
              value={notes}
              maxLength={MOST_CHARACTERS}
              onChange={(event) => setNotes(event.currentTarget.value)}
            />
          )}
        </Field>
        <div>
          <Button kind="primary" type="submit">
            Save note
          </Button>
        </div>
      </form>
    </Dialog>
  );
}
