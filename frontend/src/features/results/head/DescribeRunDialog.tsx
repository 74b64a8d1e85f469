import { useMutation, useQueryClient } from "@tanstack/react-query";

import { fieldMessageOf, messageOf } from "@/api/client";
import { runQuery, updateRun } from "@/api/runs";
import type { Run } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
import { useDraft } from "@/components/controls/drafts";
import { Field } from "@/components/controls/Field";
import { Notice } from "@/components/feedback/States";
import { shortId } from "@/lib/runs";

import styles from "./DescribeRunDialog.module.css";

const MAX_NAME_LENGTH = 80;
const MAX_NOTES_LENGTH = 4000;

/** Edits the name and the notes of a run. */
export function DescribeRunDialog({ run, onClose }: { run: Run; onClose: () => void }) {
  const client = useQueryClient();
  const draft = useDraft(`run ${run.id}`, { name: run.name, notes: run.notes });
  const { name, notes } = draft.value;
  const save = useMutation({
    mutationFn: () => updateRun(run.id, { name: name.trim(), notes: notes.trim() }),
    onSuccess: (changed) => {
      client.setQueryData(runQuery(run.id).queryKey, changed);
      void client.invalidateQueries({ queryKey: ["runs"] });
      draft.drop();
      onClose();
    },
  });
  const nameError = fieldMessageOf(save.error, "name");
  const notesError = fieldMessageOf(save.error, "notes");
  const otherError = save.error && !nameError && !notesError;
  return (
    <Dialog title="Name and notes" onClose={onClose} width="30rem">
      <form
        className={styles.form}
        noValidate
        onSubmit={(event) => {
          event.preventDefault();
          save.mutate();
        }}
      >
        <Field label="Name" hint={`Without one it is called ${shortId(run.id)}.`} error={nameError}>
          {(control) => (
            <input
              {...control}
              value={name}
              maxLength={MAX_NAME_LENGTH}
              autoComplete="off"
              onChange={(event) => draft.set({ ...draft.value, name: event.currentTarget.value })}
            />
          )}
        </Field>
        <Field label="Notes" hint="What you tried, and what came of it." error={notesError}>
          {(control) => (
            <textarea
              {...control}
              rows={5}
              value={notes}
              maxLength={MAX_NOTES_LENGTH}
              onChange={(event) => draft.set({ ...draft.value, notes: event.currentTarget.value })}
            />
          )}
        </Field>
        {otherError && (
          <Notice tone="bad" live>
            <p>{messageOf(save.error)}</p>
          </Notice>
        )}
        <div className={styles.actions}>
          <Button kind="primary" type="submit" disabled={save.isPending}>
            Save
          </Button>
          <Button
            kind="quiet"
            onClick={() => {
              draft.drop();
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
