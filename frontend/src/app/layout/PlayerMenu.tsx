import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useMutation, useQuery, useQueryClient } from "@tanstack/react-query";
import { useState } from "react";

import { messageOf } from "@/api/client";
import { connection } from "@/api/connection";
import { signOut } from "@/api/people";
import { playerQuery, renamePlayer } from "@/api/system";
import type { Player } from "@/api/types";
import { Button, ButtonLink } from "@/components/controls/Button";
import { useDraft } from "@/components/controls/drafts";
import { Field } from "@/components/controls/Field";
import { FormDialog } from "@/components/controls/FormDialog";
import { forgetDrafts } from "@/lib/browser/drafts";
import { type Language, LANGUAGES, readLanguage, setLanguage } from "@/app/language";

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
        aria-label={t`Player: ${player.name}. Change the name`}
        title={t`Change your name`}
        onClick={() => setOpen(true)}
      >
        <span className={styles.name}>{player.name}</span>
      </Button>
      {open && <RenameDialog player={player} onClose={() => setOpen(false)} />}
    </>
  );
}

function RenameDialog({
  player: { name, role },
  onClose,
}: {
  player: Player;
  onClose: () => void;
}) {
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
  const leave = useMutation({
    mutationFn: signOut,
    onSuccess: () => {
      // The next person to sign in here is another one.
      forgetDrafts();
      connection.update({ authorised: false });
    },
  });
  const answered = rename.error && refused === value ? messageOf(rename.error) : null;
  const problem = value.trim() ? answered : t`Enter a name.`;
  return (
    <FormDialog
      title={t`Your name`}
      width="24rem"
      draft={draft}
      submit={t`Save`}
      disabled={!value.trim() || rename.isPending}
      onSubmit={() => {
        if (!value.trim()) return;
        setRefused(value);
        rename.mutate(value.trim());
      }}
      onClose={onClose}
    >
      <Field label={t`Name`} hint={t`Shown beside the games you play.`} error={problem}>
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
      <LanguageField />
      <div className={styles.more}>
        {role === "owner" && (
          <ButtonLink to="/people" onClick={onClose}>
            <Trans>People</Trans>
          </ButtonLink>
        )}
        <Button
          disabled={leave.isPending}
          onClick={() => {
            leave.mutate();
          }}
        >
          <Trans>Sign out</Trans>
        </Button>
      </div>
      {leave.error && <p role="alert">{messageOf(leave.error)}</p>}
    </FormDialog>
  );
}

/** The language of the page, which changes at once and needs no saving. */
function LanguageField() {
  const [failed, setFailed] = useState(false);
  return (
    <Field
      label={t`Language`}
      hint={t`Messages of the server are in English.`}
      error={failed ? t`This language could not be loaded. Try again.` : null}
    >
      {(control) => (
        <select
          {...control}
          value={readLanguage()}
          onChange={(event) => {
            setLanguage(event.currentTarget.value as Language).catch(() => setFailed(true));
          }}
        >
          {Object.entries(LANGUAGES).map(([language, name]) => (
            <option key={language} value={language} lang={language}>
              {name}
            </option>
          ))}
        </select>
      )}
    </Field>
  );
}
