import { useQuery } from "@tanstack/react-query";

import { borrowedQuery } from "@/api/borrowed";
import type { Recording } from "@/api/types";
import { Button, IconButton } from "@/components/controls/Button";
import { useBorrowing } from "@/components/recording/use-borrowing";
import { recordingName } from "@/lib/recordings";

interface AddToRankingProps {
  recording: Recording;
  behaviourId: number;
  /** Whether only an icon is shown, which says the same by its label. */
  compact?: boolean;
}

/** Adds a policy's game to those that can be ranked, or gives it back while it is unranked. */
export function AddToRanking({ recording, behaviourId, compact = false }: AddToRankingProps) {
  const { data: borrowed } = useQuery(borrowedQuery(behaviourId));
  const { add, giveBack, isPending } = useBorrowing(behaviourId);
  if (!borrowed) return null;
  const held = borrowed.find(({ id }) => id === recording.id);
  const ranked = held?.ranked === true;
  const text = ranked ? "Ranked" : held ? "In the ranking’s games" : "Add to the ranking";
  const hint = ranked ? ". Take it off the board to give it back" : held ? ". Give it back" : "";
  const label = `${text}: ${recordingName(recording)}${hint}`;
  const shared = {
    "aria-pressed": held !== undefined,
    // Not `disabled`, which would lose the focus.
    "aria-disabled": isPending || ranked,
    onClick: () => {
      if (isPending || ranked) return;
      if (held) giveBack(held);
      else void add([recording.id]);
    },
  };
  const icon = held ? "check" : "plus";
  return compact ? (
    <IconButton icon={icon} label={label} {...shared} />
  ) : (
    <Button icon={icon} aria-label={label} title={label} {...shared}>
      {text}
    </Button>
  );
}
