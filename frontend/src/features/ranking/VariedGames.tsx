import { useMutation, useQueryClient } from "@tanstack/react-query";

import { messageOf } from "@/api/client";
import type { Behaviour, Recording } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { useToast } from "@/components/feedback/Toasts";
import { addVariedGames, giveBack, rankingQuery } from "@/features/ranking/order/rankings";

import styles from "./VariedGames.module.css";

interface VariedGamesProps {
  behaviour: Behaviour;
  unranked: readonly Recording[];
  onAdded: (ids: readonly number[]) => void;
  onSelect: (ids: readonly number[]) => void;
}

/** Adds games of other kinds to the unranked recordings, and selects those that are there. */
export function VariedGames({ behaviour, unranked, onAdded, onSelect }: VariedGamesProps) {
  const refresh = useRefresh(behaviour.id);
  const toast = useToast();
  const add = useMutation({
    mutationFn: () => addVariedGames(behaviour.id),
    onSuccess: async (added) => {
      await refresh();
      onAdded(added.map(({ id }) => id));
    },
    onError: (error) => toast(messageOf(error)),
  });
  const varied = unranked.filter((one) => one.borrowed || one.source === "random");
  return (
    <div className={styles.varied}>
      <p>
        Two dozen games of other kinds: most are bad in ways that yours are not. Tell Tril roughly
        where they belong.
      </p>
      <div className={styles.buttons}>
        <Button
          icon="plus"
          // Not `disabled`, which would lose the focus.
          aria-disabled={add.isPending}
          onClick={() => {
            if (!add.isPending) add.mutate();
          }}
        >
          {add.isPending ? "Adding…" : "Add varied games"}
        </Button>
        {varied.length > 0 && (
          <Button kind="quiet" onClick={() => onSelect(varied.map(({ id }) => id))}>
            Select all varied ({varied.length})
          </Button>
        )}
      </div>
    </div>
  );
}

/** Returns what gives a borrowed recording back. */
export function useGiveBack(behaviourId: number): (recording: Recording) => void {
  const refresh = useRefresh(behaviourId);
  const toast = useToast();
  const { mutate } = useMutation({
    mutationFn: ({ id }: Recording) => giveBack(behaviourId, id),
    onError: (error) => toast(messageOf(error)),
    onSettled: refresh,
  });
  return mutate;
}

/** Returns what loads the recordings that can be ranked again. */
function useRefresh(behaviourId: number): () => Promise<unknown> {
  const client = useQueryClient();
  return () =>
    Promise.all([
      client.invalidateQueries({ queryKey: ["recordings", behaviourId] }),
      client.invalidateQueries({ queryKey: rankingQuery(behaviourId).queryKey }),
      client.invalidateQueries({ queryKey: ["behaviours"] }),
    ]);
}
