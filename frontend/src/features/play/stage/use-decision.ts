import { t } from "@lingui/core/macro";
import { useMutation, useQueryClient } from "@tanstack/react-query";
import { useEffect, useState } from "react";

import { messageOf } from "@/api/client";
import {
  discardRecording,
  keepRecording,
  restoreRecording,
  updateRecording,
} from "@/api/recordings";
import { useToast } from "@/components/feedback/Toasts";

type Decision = "open" | "kept" | "discarded";

interface GameDecision {
  readonly decision: Decision;
  readonly perfect: boolean;
  readonly busy: boolean;
  keep: () => void;
  discard: () => void;
  /** Marks the game as perfect, keeping it, or removes the mark. */
  togglePerfect: () => void;
}

/** Whether an ended game is kept, discarded or marked as perfect; an empty one is discarded at once. */
export function useDecision(
  behaviourId: number,
  recordingId: number,
  empty: boolean,
): GameDecision {
  const client = useQueryClient();
  const toast = useToast();
  const [decision, setDecision] = useState<Decision>(empty ? "discarded" : "open");
  const [perfect, setPerfect] = useState(false);

  const change = useMutation({
    mutationFn: async (act: () => Promise<unknown>) => {
      await act();
    },
    scope: { id: `recording-${recordingId}` },
    onError: (error) => toast(messageOf(error)),
    onSettled: () => {
      void client.invalidateQueries({ queryKey: ["recordings", behaviourId] });
      void client.invalidateQueries({ queryKey: ["ranking", behaviourId] });
      void client.invalidateQueries({ queryKey: ["behaviours"] });
    },
  });

  const { mutate } = change;
  useEffect(() => {
    if (empty) mutate(() => discardRecording(recordingId));
  }, [empty, mutate, recordingId]);

  function keep() {
    if (decision !== "open") return;
    change.mutate(async () => {
      await keepRecording(recordingId);
      setDecision("kept");
    });
  }

  function discard() {
    if (decision === "discarded") return;
    change.mutate(async () => {
      await discardRecording(recordingId);
      setDecision("discarded");
      toast(t`Recording ${recordingId} discarded.`, { label: t`Undo`, run: undo });
    });
  }

  function undo() {
    change.mutate(async () => {
      await restoreRecording(recordingId);
      setDecision("kept");
    });
  }

  function togglePerfect() {
    if (decision === "discarded") return;
    change.mutate(async () => {
      if (decision === "open") await keepRecording(recordingId);
      setDecision("kept");
      await updateRecording(recordingId, { perfect: !perfect });
      setPerfect(!perfect);
    });
  }

  return { decision, perfect, busy: change.isPending, keep, discard, togglePerfect };
}
