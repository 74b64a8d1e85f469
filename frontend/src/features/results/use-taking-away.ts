import { useMutation } from "@tanstack/react-query";

import { fetchTakenAway, type TakenAway } from "@/api/runs";
import type { Behaviour, Run } from "@/api/types";
import { saveFile } from "@/lib/browser/save-file";

/** Saves a finished run as a file that the server makes. */
export function useTakingAway(run: Run, behaviour: Behaviour, onError?: (error: Error) => void) {
  return useMutation({
    mutationFn: (file: TakenAway) => fetchTakenAway(run.id, file),
    onSuccess: (content, file) => {
      const ending = file.split(".").pop() ?? "";
      saveFile(content, `tril-${behaviour.slug}-${run.id.slice(0, 8)}.${ending}`);
    },
    onError,
  });
}
