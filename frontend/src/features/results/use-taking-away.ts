import { t } from "@lingui/core/macro";
import { useMutation } from "@tanstack/react-query";

import { fetchTakenAway, type TakenAway } from "@/api/runs";
import type { Behaviour, Run } from "@/api/types";
import { useToast } from "@/components/feedback/Toasts";
import { saveFile } from "@/lib/browser/save-file";

/** Saves a finished run as a file that the server makes, and announces it. */
export function useTakingAway(run: Run, behaviour: Behaviour, onError?: (error: Error) => void) {
  const toast = useToast();
  return useMutation({
    mutationFn: (file: TakenAway) => fetchTakenAway(run.id, file),
    onSuccess: (content, file) => {
      const ending = file.split(".").pop() ?? "";
      const name = `tril-${behaviour.slug}-${run.id.slice(0, 8)}.${ending}`;
      saveFile(content, name);
      toast(savedMessage(file, name));
    },
    onError,
  });
}

function savedMessage(file: TakenAway, name: string): string {
  if (file === "page.html") return t`The page was saved as ${name}. It opens in any browser.`;
  return file === "page.png"
    ? t`The poster was saved as ${name}.`
    : t`Everything was saved as ${name}.`;
}
