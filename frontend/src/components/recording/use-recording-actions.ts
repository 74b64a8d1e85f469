import { plural, t } from "@lingui/core/macro";
import { useMutation, useQueryClient } from "@tanstack/react-query";
import { useCallback } from "react";

import { messageOf } from "@/api/client";
import {
  changeRecordings,
  deleteRecording,
  keepRecording,
  restoreRecording,
  updateRecording,
} from "@/api/recordings";
import type { LibraryEntry, Recording, RecordingsChange, RecordingUpdate } from "@/api/types";
import { type KnownLibrary, libraryQuery } from "@/api/library";
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
  changeAll: (ids: readonly number[], change: RecordingsChange["change"]) => void;
}

/** Changes to recordings, applied optimistically and rolled back if the server refuses. */
export function useRecordingActions(behaviourId: number): RecordingActions {
  const client = useQueryClient();
  const toast = useToast();
  const { queryKey } = libraryQuery(behaviourId);

  /** Shows a change in the library and on the card; returns what to restore if it is refused. */
  async function show(
    id: number,
    change: (entries: readonly LibraryEntry[]) => readonly LibraryEntry[],
    body: RecordingUpdate = {},
  ) {
    const cards = { queryKey: ["recording", id, "for"] };
    await Promise.all([client.cancelQueries({ queryKey }), client.cancelQueries(cards)]);
    const before = [
      [queryKey, client.getQueryData<KnownLibrary>(queryKey)] as const,
      ...client.getQueriesData<Recording>(cards),
    ];
    client.setQueryData<KnownLibrary>(
      queryKey,
      (known) => known && { ...known, entries: change(known.entries) },
    );
    client.setQueriesData<Recording>(cards, (one) => one && changed(one, body));
    return () => before.forEach(([key, data]) => client.setQueryData(key, data));
  }

  function settle(...ids: readonly number[]) {
    void client.invalidateQueries({ queryKey });
    if (ids.length === 0) void client.invalidateQueries({ queryKey: ["recording"] });
    for (const id of ids) void client.invalidateQueries({ queryKey: ["recording", id] });
    void client.invalidateQueries({ queryKey: ["behaviours"] });
    void client.invalidateQueries({ queryKey: ["ranking", behaviourId] });
  }

  const update = useMutation({
    mutationFn: ({ id, body }: { id: number; body: RecordingUpdate }) => updateRecording(id, body),
    onMutate: ({ id, body }) =>
      show(
        id,
        (entries) =>
          entries.map((one) =>
            one.id === id ? { ...one, perfect: body.perfect ?? one.perfect } : one,
          ),
        body,
      ),
    onError: (error, _change, takeBack) => {
      takeBack?.();
      toast(messageOf(error));
    },
    onSettled: (_answer, _error, { id }) => settle(id),
  });

  const restore = useMutation({
    mutationFn: (id: number) => restoreRecording(id),
    onError: (error) => toast(messageOf(error)),
    onSettled: (_answer, _error, id) => settle(id),
  });

  const keep = useMutation({
    mutationFn: (id: number) => keepRecording(id),
    onError: (error) => toast(messageOf(error)),
    onSettled: (_answer, _error, id) => settle(id),
  });

  const remove = useMutation({
    mutationFn: (recording: Recording) => deleteRecording(recording.id),
    onMutate: ({ id }) => show(id, (entries) => entries.filter((one) => one.id !== id)),
    onSuccess: (_nothing, recording) => {
      const name = recordingName(recording);
      toast(isUndecided(recording) ? t`${name} discarded.` : t`${name} deleted.`, {
        label: t`Undo`,
        run: () => restore.mutate(recording.id),
      });
    },
    onError: (error, _recording, takeBack) => {
      takeBack?.();
      toast(messageOf(error));
    },
    onSettled: (_answer, _error, { id }) => settle(id),
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
    onSettled: () => settle(),
  });

  const { mutate: send } = update;
  const setPerfect: RecordingActions["setPerfect"] = useCallback(
    ({ id }, perfect) => send({ id, body: { perfect } }),
    [send],
  );
  return {
    setPerfect,
    setNotes: ({ id }, notes) => update.mutateAsync({ id, body: { notes } }),
    keep: ({ id }) => keep.mutate(id),
    remove: (recording) => remove.mutate(recording),
    restore: ({ id }) => restore.mutate(id),
    changeAll: (ids, change) => changeAll.mutate({ recording_ids: [...ids], change }),
  };
}

function changed(recording: Recording, { perfect, notes }: RecordingUpdate): Recording {
  return {
    ...recording,
    perfect: perfect ?? recording.perfect,
    notes: notes ?? recording.notes,
  };
}
