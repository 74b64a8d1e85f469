import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useMutation, useQuery, useQueryClient } from "@tanstack/react-query";
import { useState } from "react";

import { behavioursQuery } from "@/api/behaviours";
import { messageOf } from "@/api/client";
import { addGames } from "@/api/library";
import type { Behaviour, LibraryEntry } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Select } from "@/components/controls/Filters";
import { useToast } from "@/components/feedback/Toasts";
import { useBorrowing } from "@/components/recording/use-borrowing";
import type { Tiers } from "@/features/ranking/order/order";
import { rankingQuery } from "@/features/ranking/order/rankings";

import styles from "./TakeOver.module.css";

interface TakeOverProps {
  behaviour: Behaviour;
  /** What the behaviour can rank already. */
  recordings: readonly LibraryEntry[];
  /** Called with the order that the games have there. */
  onTaken: (tiers: Tiers) => void;
}

/** Borrows the ranked games of another behaviour of the same game, in their order. */
export function TakeOver({ behaviour, recordings, onTaken }: TakeOverProps) {
  const { data: all = [] } = useQuery(behavioursQuery);
  const [chosen, setChosen] = useState("");
  const client = useQueryClient();
  const { refresh } = useBorrowing(behaviour.id);
  const toast = useToast();
  const take = useMutation({
    mutationFn: async (from: Behaviour) => {
      const { tiers } = await client.query({ ...rankingQuery(from.id), staleTime: 0 });
      const held = new Set(recordings.map(({ id }) => id));
      const missing = tiers.flat().filter((id) => !held.has(id));
      if (missing.length > 0) await addGames(behaviour.id, missing);
      return tiers;
    },
    onSuccess: (tiers) => {
      onTaken(tiers);
      return refresh();
    },
    onError: (error) => toast(messageOf(error)),
  });
  const others = all.filter(
    (one) => one.game === behaviour.game && one.id !== behaviour.id && one.n_ranked > 0,
  );
  const from = others.find(({ id }) => String(id) === chosen) ?? others[0];
  if (!from) return null;
  const { name } = from;
  return (
    <div className={styles.takeOver} role="group" aria-label={t`Games of another behaviour`}>
      <p>
        <Trans>
          Games that you ranked for another behaviour can be used here, too. They keep their order,
          which you can change or reverse.
        </Trans>
      </p>
      <div className={styles.choice}>
        {others.length > 1 && (
          <Select
            label={t`Behaviour`}
            value={String(from.id)}
            options={others.map((one) => [String(one.id), one.name] as const)}
            onChange={setChosen}
          />
        )}
        <Button
          icon="compare"
          // Not `disabled`, which would lose the focus.
          aria-disabled={take.isPending}
          onClick={() => {
            if (!take.isPending) take.mutate(from);
          }}
        >
          {take.isPending
            ? t`Taking over…`
            : plural(from.n_ranked, {
                one: `Take over the # game of ${name}`,
                other: `Take over the # games of ${name}`,
              })}
        </Button>
      </div>
    </div>
  );
}
