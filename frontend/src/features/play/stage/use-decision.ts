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
import { recordingName } from "@/lib/recordings";

type Decision = "open" | "kept" | "discarded";

interface GameDecision {
  readonly decision: Decision;
  readonly perfect: boolean;
  /** The recording's name, known once something is decided. */
  readonly name: string;
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
  const [name, setName] = useState("");

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
      setName(recordingName(await keepRecording(recordingId)));
      setDecision("kept");
    });
  }

  function discard() {
    if (decision === "discarded") return;
    change.mutate(async () => {
      const discarded = recordingName(await discardRecording(recordingId));
      setDecision("discarded");
      toast(t`${discarded} discarded.`, { label: t`Undo`, run: undo });
    });
  }

  function undo() {
    change.mutate(async () => {
      setName(recordingName(await restoreRecording(recordingId)));
      setDecision("kept");
    });
  }

  function togglePerfect() {
    if (decision === "discarded") return;
    change.mutate(async () => {
      if (decision === "open") setName(recordingName(await keepRecording(recordingId)));
      setDecision("kept");
      await updateRecording(recordingId, { perfect: !perfect });
      setPerfect(!perfect);
    });
  }

  return { decision, perfect, name, busy: change.isPending, keep, discard, togglePerfect };
}
