import { t } from "@lingui/core/macro";
import { useMutation, useQueryClient } from "@tanstack/react-query";
import { useNavigate } from "react-router";

import { behavioursQuery, createBehaviour } from "@/api/behaviours";
import { useDraft } from "@/components/controls/drafts";

import { BehaviourDialog } from "./BehaviourDialog";
import { type BehaviourDraft, EMPTY_DRAFT } from "./draft";

interface NewBehaviourDialogProps {
  onClose: () => void;
  title?: string;
  /** What the form begins with. */
  initial?: BehaviourDraft;
}

/** Creates a behaviour: a game, what is to be shown in it, a name and optionally a target. */
export function NewBehaviourDialog({
  onClose,
  title = t`New behaviour`,
  initial = EMPTY_DRAFT,
}: NewBehaviourDialogProps) {
  const client = useQueryClient();
  const navigate = useNavigate();
  const draft = useDraft(`${title} ${initial.game} ${initial.name}`, initial);
  const create = useMutation({
    mutationFn: createBehaviour,
    onSuccess: async (behaviour) => {
      draft.drop();
      await client.invalidateQueries({ queryKey: behavioursQuery.queryKey });
      onClose();
      await navigate(`/behaviours/${behaviour.id}/play`);
    },
  });
  return (
    <BehaviourDialog
      title={title}
      draft={draft}
      onSubmit={(behaviour) => create.mutate(behaviour)}
      onClose={onClose}
      submit={create.isPending ? t`Creating…` : t`Create behaviour`}
      pending={create.isPending}
      error={create.error}
    />
  );
}
