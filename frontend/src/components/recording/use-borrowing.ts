import { useMutation, useQueryClient } from "@tanstack/react-query";

import { addGames, giveBack } from "@/api/library";
import { messageOf } from "@/api/client";
import type { Recording } from "@/api/types";
import { useToast } from "@/components/feedback/Toasts";

interface Borrowing {
  /** Adds recordings to the ranking's games, all or none; resolves to whether they are in. */
  add: (ids: readonly number[]) => Promise<boolean>;
  giveBack: (recording: Pick<Recording, "id">) => void;
  isPending: boolean;
  /** Loads the recordings that can be ranked again. */
  refresh: () => Promise<unknown>;
}

/** Changes which recordings a behaviour's ranking may hold besides the behaviour's own. */
export function useBorrowing(behaviourId: number): Borrowing {
  const client = useQueryClient();
  const toast = useToast();
  const refresh = () =>
    Promise.all([
      client.invalidateQueries({ queryKey: ["recordings", behaviourId] }),
      client.invalidateQueries({ queryKey: ["ranking", behaviourId] }),
      client.invalidateQueries({ queryKey: ["behaviours"] }),
    ]);
  const settle = { onError: (error: Error) => toast(messageOf(error)), onSettled: refresh };
  const adding = useMutation({
    mutationFn: (ids: readonly number[]) => addGames(behaviourId, ids),
    ...settle,
  });
  const givingBack = useMutation({
    mutationFn: ({ id }: Pick<Recording, "id">) => giveBack(behaviourId, id),
    ...settle,
  });
  return {
    add: (ids) =>
      adding.mutateAsync(ids).then(
        () => true,
        () => false,
      ),
    giveBack: givingBack.mutate,
    isPending: adding.isPending || givingBack.isPending,
    refresh,
  };
}
