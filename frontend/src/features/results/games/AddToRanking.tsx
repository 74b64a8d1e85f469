import { t } from "@lingui/core/macro";
import { useQuery } from "@tanstack/react-query";

import { borrowedQuery } from "@/api/library";
import type { Recording } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { useBorrowing } from "@/components/recording/use-borrowing";
import { recordingName } from "@/lib/recordings";

interface AddToRankingProps {
  recording: Recording;
  behaviourId: number;
  kind?: "secondary" | "quiet";
}

/** Adds a policy's game to those that can be ranked, or gives it back while it is unranked. */
export function AddToRanking({ recording, behaviourId, kind }: AddToRankingProps) {
  const { data: borrowed } = useQuery(borrowedQuery(behaviourId));
  const { add, giveBack, isPending } = useBorrowing(behaviourId);
  if (!borrowed) return null;
  const held = borrowed.find(({ id }) => id === recording.id);
  const ranked = held?.ranked === true;
  const text = ranked ? t`Ranked` : held ? t`In the ranking’s games` : t`Add to the ranking`;
  const action = ranked ? t`Take it off the board to give it back` : held ? t`Give it back` : "";
  const label = [`${text}: ${recordingName(recording)}`, action].filter(Boolean).join(". ");
  return (
    <Button
      kind={kind}
      icon={held ? "check" : "plus"}
      aria-label={label}
      title={label}
      aria-pressed={held !== undefined}
      // Not `disabled`, which would lose the focus.
      aria-disabled={isPending || ranked}
      onClick={() => {
        if (isPending || ranked) return;
        if (held) giveBack(held);
        else void add([recording.id]);
      }}
    >
      {text}
    </Button>
  );
}
