import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useMutation, useQuery } from "@tanstack/react-query";

import { messageOf } from "@/api/client";
import { createKey, keysQuery, revokeKey } from "@/api/people";
import type { KeyNew } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { useDraft } from "@/components/controls/drafts";
import { Field } from "@/components/controls/Field";
import { Failed, Loading, Notice } from "@/components/feedback/States";
import { moment } from "@/lib/format";

import { Credential } from "./Credential";
import styles from "./PeoplePage.module.css";
import { Secret } from "./Secret";
import { roleName } from "./words";

/** The keys of scripts, each with a button that revokes it, and a form that makes one. */
export function Keys() {
  const { data: keys, error, refetch } = useQuery(keysQuery);
  const revoke = useMutation({ mutationFn: revokeKey, onSettled: () => void refetch() });
  const draft = useDraft<Pick<KeyNew, "name" | "role">>("key", { name: "", role: "researcher" });
  const { name, role } = draft.value;
  const make = useMutation({
    mutationFn: createKey,
    onSuccess: () => {
      draft.set({ name: "", role: "researcher" });
      void refetch();
    },
  });
  if (error && !keys) {
    return <Failed what={t`The keys`} error={error} onRetry={() => void refetch()} />;
  }
  if (!keys) return <Loading what={t`the keys`} rows={1} height="3rem" />;
  return (
    <>
      {revoke.error && (
        <Notice tone="bad" live>
          {messageOf(revoke.error)}
        </Notice>
      )}
      <ul className={styles.rows}>
        {keys.map(({ id, name: what, role: rights, seen_at: seen }) => (
          <Credential
            key={id}
            note={seen ? t`Last used ${moment(seen)}` : t`Not used yet`}
            end={{
              label: t`Revoke`,
              name: t`Revoke the key ${what}`,
              disabled: revoke.isPending,
              onClick: () => revoke.mutate(id),
            }}
          >
            <strong>{what}</strong> ({roleName(rights)})
          </Credential>
        ))}
      </ul>
      <form
        className={styles.form}
        onSubmit={(event) => {
          event.preventDefault();
          if (!name.trim()) return;
          make.mutate({ name: name.trim(), role });
        }}
      >
        <Field label={t`What the key is for`} error={make.error ? messageOf(make.error) : null}>
          {(control) => (
            <input
              {...control}
              value={name}
              maxLength={80}
              required
              onChange={(event) => draft.set({ name: event.currentTarget.value, role })}
            />
          )}
        </Field>
        <Field label={t`What it may do`}>
          {(control) => (
            <select
              {...control}
              value={role}
              onChange={(event) =>
                draft.set({ name, role: event.currentTarget.value as KeyNew["role"] })
              }
            >
              <option value="researcher">{t`The same as a researcher`}</option>
              <option value="owner">{t`Everything that you may do`}</option>
              <option value="worker">{t`Start workers on other machines, and nothing else`}</option>
            </select>
          )}
        </Field>
        <Button kind="primary" type="submit" disabled={!name.trim() || make.isPending}>
          <Trans>Make a key</Trans>
        </Button>
        {make.data && <Secret value={make.data.key} />}
      </form>
    </>
  );
}
