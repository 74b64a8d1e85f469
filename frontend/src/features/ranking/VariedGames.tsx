import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useMutation } from "@tanstack/react-query";

import { messageOf } from "@/api/client";
import type { Behaviour, Recording } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { useToast } from "@/components/feedback/Toasts";
import { useBorrowing } from "@/components/recording/use-borrowing";
import { addVariedGames } from "@/features/ranking/order/rankings";

import styles from "./VariedGames.module.css";

interface VariedGamesProps {
  behaviour: Behaviour;
  /** The unranked games of these kinds. */
  varied: readonly number[];
  onAdded: (added: readonly Recording[]) => void;
  onSelect: (ids: readonly number[]) => void;
}

/** Adds games of other kinds to the unranked recordings, and selects those that are there. */
export function VariedGames({ behaviour, varied, onAdded, onSelect }: VariedGamesProps) {
  const { refresh } = useBorrowing(behaviour.id);
  const toast = useToast();
  const add = useMutation({
    mutationFn: () => addVariedGames(behaviour.id),
    onSuccess: async (added) => {
      await refresh();
      onAdded(added);
    },
    onError: (error) => toast(messageOf(error)),
  });
  return (
    <div className={styles.varied}>
      <p>
        <Trans>
          Two dozen ready-made games, most of them bad in ways that yours are not. Put each roughly
          where it belongs.
        </Trans>
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
          {add.isPending ? t`Playing games…` : t`Add varied games`}
        </Button>
        {varied.length > 0 && (
          <Button kind="quiet" onClick={() => onSelect(varied)}>
            <Trans>Select all varied ({varied.length})</Trans>
          </Button>
        )}
      </div>
    </div>
  );
}
