import { t } from "@lingui/core/macro";
import { useMutation, useQueryClient } from "@tanstack/react-query";

import { fieldMessageOf } from "@/api/client";
import { runQuery, updateRun } from "@/api/runs";
import type { Run } from "@/api/types";
import { useDraft } from "@/components/controls/drafts";
import { Field } from "@/components/controls/Field";
import { FormDialog } from "@/components/controls/FormDialog";
import { shortId } from "@/lib/runs";

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
  return (
    <FormDialog
      title={t`Name and notes`}
      width="30rem"
      draft={draft}
      submit={t`Save`}
      disabled={save.isPending}
      error={nameError || notesError ? null : save.error}
      onSubmit={() => save.mutate()}
      onClose={onClose}
    >
      <Field
        label={t`Name`}
        hint={t`Without one it is called ${shortId(run.id)}.`}
        error={nameError}
      >
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
      <Field label={t`Notes`} hint={t`What you tried, and what came of it.`} error={notesError}>
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
    </FormDialog>
  );
}
