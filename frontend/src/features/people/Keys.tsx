import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useMutation, useQuery } from "@tanstack/react-query";
import { useState } from "react";

import { messageOf } from "@/api/client";
import { createKey, keysQuery, revokeKey } from "@/api/people";
import { Button } from "@/components/controls/Button";
import { Checkbox, Field } from "@/components/controls/Field";
import { Failed, Loading } from "@/components/feedback/States";
import { moment } from "@/lib/format";

import styles from "./PeoplePage.module.css";
import { Secret } from "./Secret";
import { roleName } from "./words";

/** The keys of scripts, each with a button that revokes it, and a form that makes one. */
export function Keys() {
  const { data: keys, error, refetch } = useQuery(keysQuery);
  const revoke = useMutation({ mutationFn: revokeKey, onSettled: () => void refetch() });
  const [name, setName] = useState("");
  const [owner, setOwner] = useState(false);
  const make = useMutation({
    mutationFn: createKey,
    onSuccess: () => {
      setName("");
      void refetch();
    },
  });
  if (error && !keys) {
    return <Failed what={t`The keys`} error={error} onRetry={() => void refetch()} />;
  }
  if (!keys) return <Loading what={t`the keys`} rows={1} height="3rem" />;
  return (
    <>
      <ul className={styles.rows}>
        {keys.map(({ id, name: what, role, seen_at: seen }) => (
          <li key={id}>
            <span className={styles.what}>
              <strong>{what}</strong> ({roleName(role)})
              <small>{seen ? t`Last used ${moment(seen)}` : t`Not used yet`}</small>
            </span>
            <Button
              aria-label={t`Revoke the key ${what}`}
              disabled={revoke.isPending}
              onClick={() => revoke.mutate(id)}
            >
              <Trans>Revoke</Trans>
            </Button>
          </li>
        ))}
      </ul>
      {revoke.error && <p role="alert">{messageOf(revoke.error)}</p>}
      <form
        className={styles.form}
        onSubmit={(event) => {
          event.preventDefault();
          if (!name.trim()) return;
          make.mutate({ name: name.trim(), role: owner ? "owner" : "researcher" });
        }}
      >
        <Field label={t`What the key is for`} error={make.error ? messageOf(make.error) : null}>
          {(control) => (
            <input
              {...control}
              value={name}
              maxLength={80}
              required
              onChange={(event) => setName(event.currentTarget.value)}
            />
          )}
        </Field>
        <Checkbox
          label={t`It may do everything, as you may`}
          hint={t`Otherwise it may do what researchers may.`}
          checked={owner}
          onChange={setOwner}
        />
        <Button kind="primary" type="submit" disabled={!name.trim() || make.isPending}>
          <Trans>Make a key</Trans>
        </Button>
        {make.data && <Secret value={make.data.key} />}
      </form>
    </>
  );
}
