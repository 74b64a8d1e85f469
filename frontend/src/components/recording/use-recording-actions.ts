import { plural, t } from "@lingui/core/macro";
import { useMutation, useQueryClient } from "@tanstack/react-query";

import { messageOf } from "@/api/client";
import {
  changeRecordings,
  deleteRecording,
  keepRecording,
  recordingsQuery,
  restoreRecording,
  updateRecording,
} from "@/api/recordings";
import type { Recording, RecordingsChange, RecordingUpdate } from "@/api/types";
import { useToast } from "@/components/feedback/Toasts";
import { isUndecided, recordingName } from "@/lib/recordings";

interface RecordingActions {
  setPerfect: (recording: Recording, perfect: boolean) => void;
  /** Settles when they are saved or refused, which is said. */
  setNotes: (recording: Recording, notes: string) => Promise<unknown>;
  /** Puts an undecided or unfinished game into the library. */
  keep: (recording: Recording) => void;
  remove: (recording: Recording) => void;
  restore: (recording: Recording) => void;
  /** Applies one change to several recordings, atomically; deletion can be undone. */
  changeAll: (recordings: readonly Recording[], change: RecordingsChange["change"]) => void;
}

/** Changes to recordings, applied optimistically and rolled back if the server refuses. */
export function useRecordingActions(behaviourId: number): RecordingActions {
  const client = useQueryClient();
  const toast = useToast();
  const { queryKey } = recordingsQuery(behaviourId);

  function show(change: (list: Recording[]) => Recording[]) {
    const before = client.getQueryData(queryKey);
    client.setQueryData(queryKey, (list) => list && change(list));
    return before;
  }

  function settle() {
    void client.invalidateQueries({ queryKey });
    void client.invalidateQueries({ queryKey: ["recording"] });
    void client.invalidateQueries({ queryKey: ["behaviours"] });
    void client.invalidateQueries({ queryKey: ["ranking", behaviourId] });
  }

  const update = useMutation({
    mutationFn: ({ id, body }: { id: number; body: RecordingUpdate }) => updateRecording(id, body),
    onMutate: async ({ id, body }) => {
      await client.cancelQueries({ queryKey });
      return show((list) => list.map((one) => (one.id === id ? changed(one, body) : one)));
    },
    onError: (error, _change, before) => {
      client.setQueryData(queryKey, before);
      toast(messageOf(error));
    },
    onSettled: settle,
  });

  const restore = useMutation({
    mutationFn: (id: number) => restoreRecording(id),
    onError: (error) => toast(messageOf(error)),
    onSettled: settle,
  });

  const keep = useMutation({
    mutationFn: (id: number) => keepRecording(id),
    onError: (error) => toast(messageOf(error)),
    onSettled: settle,
  });

  const remove = useMutation({
    mutationFn: (recording: Recording) => deleteRecording(recording.id),
    onMutate: async (recording) => {
      await client.cancelQueries({ queryKey });
      return show((list) => list.filter((one) => one.id !== recording.id));
    },
    onSuccess: (_nothing, recording) => {
      const name = recordingName(recording);
      toast(isUndecided(recording) ? t`${name} discarded.` : t`${name} deleted.`, {
        label: t`Undo`,
        run: () => restore.mutate(recording.id),
      });
    },
    onError: (error, _recording, before) => {
      client.setQueryData(queryKey, before);
      toast(messageOf(error));
    },
    onSettled: settle,
  });

  const changeAll = useMutation({
    mutationFn: (body: RecordingsChange) => changeRecordings(behaviourId, body),
    onSuccess: (_changed, { change, recording_ids: ids }) => {
      if (change !== "delete") return;
      toast(plural(ids.length, { one: "# recording deleted.", other: "# recordings deleted." }), {
        label: t`Undo`,
        run: () => changeAll.mutate({ recording_ids: ids, change: "restore" }),
      });
    },
    onError: (error) => toast(messageOf(error)),
    onSettled: settle,
  });

  return {
    setPerfect: ({ id }, perfect) => update.mutate({ id, body: { perfect } }),
    setNotes: ({ id }, notes) => update.mutateAsync({ id, body: { notes } }),
    keep: ({ id }) => keep.mutate(id),
    remove: (recording) => remove.mutate(recording),
    restore: ({ id }) => restore.mutate(id),
    changeAll: (recordings, change) =>
      changeAll.mutate({ recording_ids: recordings.map(({ id }) => id), change }),
  };
}

function changed(recording: Recording, { perfect, notes }: RecordingUpdate): Recording {
  return {
    ...recording,
    perfect: perfect ?? recording.perfect,
    notes: notes ?? recording.notes,
  };
}
