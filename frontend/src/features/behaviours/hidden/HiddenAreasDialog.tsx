import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useMutation, useQuery, useQueryClient } from "@tanstack/react-query";

import { behavioursQuery, updateBehaviour } from "@/api/behaviours";
import { gameQuery } from "@/games/catalogue";
import type { Behaviour } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { useDraft } from "@/components/controls/drafts";
import { FormDialog } from "@/components/controls/FormDialog";
import { useGame } from "@/games/game";

import { type Area, isSame, middle, MOST_AREAS } from "./areas";
import { AreaEditor } from "./AreaEditor";
import { AreaFields } from "./AreaFields";
import styles from "./HiddenAreas.module.css";

interface HiddenAreasDialogProps {
  behaviour: Behaviour;
  onClose: () => void;
}

/** Shows what of the screen learning does not see, and changes it until a run was trained. */
export function HiddenAreasDialog({ behaviour, onClose }: HiddenAreasDialogProps) {
  const client = useQueryClient();
  const game = useGame();
  // As the game proposes it, whatever the behaviour has set.
  const { data: plain } = useQuery(gameQuery(game.name));
  const proposed: readonly Area[] = plain?.hidden ?? [];
  const draft = useDraft<{ areas: readonly Area[] }>(`hidden ${behaviour.id}`, {
    areas: game.hidden,
  });
  const { areas } = draft.value;
  const set = (next: readonly Area[]) => draft.set({ areas: next });
  const fixed = whyFixed(behaviour);
  const isProposed = isSame(areas, proposed);
  const update = useMutation({
    mutationFn: () =>
      updateBehaviour(behaviour.id, {
        settings: {
          ...behaviour.settings,
          hidden: isProposed ? null : areas.map(([...area]) => [...area] as Edges),
        },
      }),
    onSuccess: async () => {
      draft.drop();
      await client.invalidateQueries({ queryKey: behavioursQuery.queryKey });
      onClose();
    },
  });
  return (
    <FormDialog
      title={t`What learning sees`}
      width="52rem"
      draft={draft}
      submit={update.isPending ? t`Saving…` : t`Save`}
      disabled={fixed !== null || update.isPending}
      error={update.error}
      onSubmit={() => update.mutate()}
      onClose={onClose}
    >
      <p className={styles.note}>
        <Trans>
          Neither the reward nor the imitator sees what is covered. Cover the score and the lives,
          so that it learns from your order alone.
        </Trans>
      </p>
      {fixed !== null && <p className={styles.note}>{fixed}</p>}
      <div className={styles.editor}>
        <AreaEditor areas={areas} readOnly={fixed !== null} onChange={set} />
        <div className={styles.list}>
          {areas.length === 0 && (
            <p className={styles.note}>
              <Trans>Nothing is covered.</Trans>
            </p>
          )}
          {areas.map((area, index) => (
            <AreaFields
              key={index}
              number={index + 1}
              area={area}
              readOnly={fixed !== null}
              onChange={(next) => set(areas.map((old, at) => (at === index ? next : old)))}
              onRemove={() => set(areas.filter((_, at) => at !== index))}
            />
          ))}
          {fixed === null && (
            <div className={styles.buttons}>
              <Button
                icon="plus"
                disabled={areas.length >= MOST_AREAS}
                onClick={() => set([...areas, middle(game)])}
              >
                <Trans>Cover another area</Trans>
              </Button>
              <Button kind="quiet" disabled={isProposed} onClick={() => set(proposed)}>
                <Trans>As proposed</Trans>
              </Button>
            </div>
          )}
        </div>
      </div>
    </FormDialog>
  );
}

type Edges = [number, number, number, number];

/** Why the areas can't be changed; null if they can. */
function whyFixed({ built_in, n_runs }: Behaviour): string | null {
  if (built_in) return t`A built-in behaviour stays as it is.`;
  return n_runs > 0 ? t`It stays as it is, since a run has learned from it.` : null;
}
