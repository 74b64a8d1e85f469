import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useMutation, useQuery, useQueryClient } from "@tanstack/react-query";
import { useNavigate } from "react-router";

import {
  behavioursQuery,
  deleteBehaviour,
  restoreBehaviour,
  updateBehaviour,
} from "@/api/behaviours";
import { messageOf } from "@/api/client";
import type { Behaviour, BehaviourNew, BehaviourUpdate, TaughtGame } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { useDraft } from "@/components/controls/drafts";
import { useToast } from "@/components/feedback/Toasts";
import { useGame } from "@/games/game";

import { BehaviourDialog } from "./BehaviourDialog";
import styles from "./BehaviourDialog.module.css";
import { copyOf, draftOf } from "./draft";
import { GameMark } from "./GameMark";
import { HiddenAreasDialog } from "./hidden/HiddenAreasDialog";
import { NewBehaviourDialog } from "./NewBehaviourDialog";

/** What is done with a behaviour: "edit", "copy", or "hidden" for what learning does not see. */
export type Editing = "edit" | "copy" | "hidden";

interface EditDialogsProps {
  behaviour: Behaviour;
  editing: Editing;
  onEdit: (editing: Editing | null) => void;
}

/** The dialogs that edit, copy or delete a behaviour. */
export function EditDialogs({ behaviour, editing, onEdit }: EditDialogsProps) {
  const game = useGame();
  const { data: all } = useQuery(behavioursQuery);
  const close = () => onEdit(null);
  if (editing === "hidden") return <HiddenAreasDialog behaviour={behaviour} onClose={close} />;
  if (editing === "edit")
    return <EditDialog behaviour={behaviour} onClose={close} onCopy={() => onEdit("copy")} />;
  return (
    <NewBehaviourDialog
      title={game.items ? t`Copy with another target` : t`Copy, played otherwise`}
      initial={copyOf(behaviour, all ?? [behaviour], game)}
      onClose={close}
    />
  );
}

interface EditDialogProps {
  behaviour: Behaviour;
  onClose: () => void;
  onCopy: () => void;
}

function EditDialog({ behaviour, onClose, onCopy }: EditDialogProps) {
  const client = useQueryClient();
  const game = useGame();
  const draft = useDraft(`behaviour ${behaviour.id}`, draftOf(behaviour, game));
  const fixed = whyFixed(behaviour, game);
  const remove = useDeletion(behaviour);
  const update = useMutation({
    mutationFn: (change: BehaviourNew) =>
      updateBehaviour(
        behaviour.id,
        fixed === null
          ? withoutGame(change)
          : { name: change.name, description: change.description, measures: change.measures },
      ),
    onSuccess: async () => {
      draft.drop();
      await client.invalidateQueries({ queryKey: behavioursQuery.queryKey });
      onClose();
    },
  });
  return (
    <BehaviourDialog
      title={t`Edit the behaviour`}
      draft={draft}
      onSubmit={(change) => update.mutate(change)}
      onClose={onClose}
      edited={behaviour}
      fixed={
        fixed === null ? undefined : (
          <div className={styles.fixed}>
            <GameMark target={behaviour.target} />
            <div>
              <p>{fixed}</p>
              <Button onClick={onCopy}>
                {game.items ? t`Make a copy with another target` : t`Make a copy`}
              </Button>
            </div>
          </div>
        )
      }
      submit={update.isPending ? t`Saving…` : t`Save`}
      pending={update.isPending}
      error={update.error ?? remove.error}
      more={
        !behaviour.built_in && (
          <Button
            kind="danger"
            icon="trash"
            disabled={remove.isPending}
            onClick={() => remove.mutate()}
          >
            <Trans>Delete</Trans>
          </Button>
        )
      }
    />
  );
}

/** What changes of a behaviour, which stays one of its game. */
function withoutGame(change: BehaviourNew): BehaviourUpdate {
  const { name, description, target = null, ordered, settings, measures } = change;
  return { name, description, target, ordered, settings, measures };
}

/** Deletes a behaviour; its toast restores it. */
function useDeletion(behaviour: Behaviour) {
  const client = useQueryClient();
  const navigate = useNavigate();
  const toast = useToast();
  const settle = () => {
    void client.invalidateQueries({ queryKey: behavioursQuery.queryKey });
    void client.invalidateQueries({ queryKey: ["runs"] });
  };
  const restore = useMutation({
    mutationFn: () => restoreBehaviour(behaviour.id),
    onError: (error) => toast(messageOf(error)),
    onSettled: settle,
  });
  return useMutation({
    mutationFn: () => deleteBehaviour(behaviour.id),
    onSuccess: async () => {
      await navigate("/");
      settle();
      toast(t`${behaviour.name} deleted.`, { label: t`Undo`, run: () => restore.mutate() });
    },
  });
}

/** Why target and settings can't be changed; null if they can. */
function whyFixed({ built_in, n_recordings, n_runs }: Behaviour, game: TaughtGame): string | null {
  if (built_in)
    return t`The target of a built-in behaviour stays as it is, and so does how it is played.`;
  if (n_recordings === 0 && n_runs === 0) return null;
  return game.items
    ? t`The target and how it is played stay as they are, since games were recorded.`
    : t`How it is played stays as it is, since games were recorded.`;
}
