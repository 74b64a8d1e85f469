import { useMutation, useQuery, useQueryClient } from "@tanstack/react-query";
import { useState } from "react";

import { messageOf } from "@/api/client";
import { playerQuery, renamePlayer } from "@/api/system";
import { Button } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
import { useDraft } from "@/components/controls/drafts";
import { Field } from "@/components/controls/Field";

import styles from "./PlayerMenu.module.css";

/** The player's name, with a dialog to change it. */
export function PlayerMenu() {
  const { data: player } = useQuery(playerQuery);
  const [open, setOpen] = useState(false);
  if (!player) return null;
  return (
    <>
      <Button
        kind="quiet"
        aria-label={`Player: ${player.name}. Change the name`}
        title="Change your name"
        onClick={() => setOpen(true)}
      >
        <span className={styles.name}>{player.name}</span>
      </Button>
      {open && <RenameDialog name={player.name} onClose={() => setOpen(false)} />}
    </>
  );
}

function RenameDialog({ name, onClose }: { name: string; onClose: () => void }) {
  const client = useQueryClient();
  const draft = useDraft("your name", name);
  const { value } = draft;
  const [refused, setRefused] = useState<string | null>(null);
  const rename = useMutation({
    mutationFn: renamePlayer,
    onSuccess: (player) => {
      client.setQueryData(playerQuery.queryKey, player);
      draft.drop();
      onClose();
    },
  });
  const answered = rename.error && refused === value ? messageOf(rename.error) : null;
  const problem = value.trim() ? answered : "Give a name.";
  return (
    <Dialog title="Your name" onClose={onClose} width="24rem">
      <form
        className={styles.form}
        onSubmit={(event) => {
          event.preventDefault();
          if (!value.trim()) return;
          setRefused(value);
          rename.mutate(value.trim());
        }}
      >
        <Field label="Name" hint="Shown beside the games you play." error={problem}>
          {(control) => (
            <input
              {...control}
              value={value}
              maxLength={80}
              autoComplete="nickname"
              onChange={(event) => draft.set(event.currentTarget.value)}
            />
          )}
        </Field>
        <div className={styles.actions}>
          <Button kind="primary" type="submit" disabled={!value.trim() || rename.isPending}>
            Save
          </Button>
          <Button
            kind="quiet"
            onClick={() => {
              draft.drop();
              onClose();
            }}
          >
            Cancel
          </Button>
        </div>
      </form>
    </Dialog>
  );
}
