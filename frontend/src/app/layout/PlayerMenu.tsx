import { useMutation, useQuery, useQueryClient } from "@tanstack/react-query";
import { useState } from "react";

import { messageOf } from "@/api/client";
import { playerQuery, renamePlayer } from "@/api/system";
import { Button } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
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
  const [value, setValue] = useState(name);
  const rename = useMutation({
    mutationFn: renamePlayer,
    onSuccess: (player) => {
      client.setQueryData(playerQuery.queryKey, player);
      onClose();
    },
  });
  return (
    <Dialog title="Your name" onClose={onClose} width="24rem">
      <form
        className={styles.form}
        onSubmit={(event) => {
          event.preventDefault();
          if (value.trim()) rename.mutate(value.trim());
        }}
      >
        <Field
          label="Name"
          hint="Shown beside the games you play."
          error={rename.error ? messageOf(rename.error) : null}
        >
          {(control) => (
            <input
              {...control}
              value={value}
              maxLength={80}
              autoComplete="nickname"
              onChange={(event) => setValue(event.currentTarget.value)}
            />
          )}
        </Field>
        <div>
          <Button kind="primary" type="submit" disabled={!value.trim() || rename.isPending}>
            Save
          </Button>
        </div>
      </form>
    </Dialog>
  );
}
