import { t } from "@lingui/core/macro";

import type { Recording } from "@/api/types";
import { useDraft } from "@/components/controls/drafts";
import { Field } from "@/components/controls/Field";
import { FormDialog } from "@/components/controls/FormDialog";
import { inSentence } from "@/lib/format";
import { recordingName } from "@/lib/recordings";

const MOST_CHARACTERS = 4000;

/** Edits the note on a recording. */
export function NotesDialog({
  recording,
  onSave,
  onClose,
}: {
  recording: Recording;
  onSave: (notes: string) => Promise<unknown>;
  onClose: () => void;
}) {
  const notes = useDraft(`note ${recording.id}`, recording.notes);
  return (
    <FormDialog
      title={t`Note on ${inSentence(recordingName(recording))}`}
      draft={notes}
      submit={t`Save note`}
      onSubmit={() => {
        // If it is refused, it is still there when the dialog is opened again.
        onSave(notes.value.trim()).then(notes.drop, () => undefined);
        onClose();
      }}
      onClose={onClose}
    >
      <Field label={t`Note`}>
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
    </FormDialog>
  );
}
