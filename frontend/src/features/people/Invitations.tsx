import { t } from "@lingui/core/macro";
import { Plural, Trans } from "@lingui/react/macro";
import { useMutation, useQuery } from "@tanstack/react-query";

import { behavioursQuery } from "@/api/behaviours";
import { messageOf } from "@/api/client";
import { createInvitation, invitationsQuery, revokeInvitation } from "@/api/people";
import type { Invitation } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { useDraft } from "@/components/controls/drafts";
import { Field } from "@/components/controls/Field";
import { Failed, Loading, Notice } from "@/components/feedback/States";
import { useFirst } from "@/components/list/use-first";
import { moment } from "@/lib/format";

import { Credential } from "./Credential";
import styles from "./PeoplePage.module.css";
import { Secret } from "./Secret";
import { roleName } from "./words";

const RESEARCHERS = "researchers";

/** What the server takes; its defaults are for a class. */
const USES = { default: 30, most: 1000 };
const DAYS = { default: 30, most: 366 };

/** The invitations, each with a button that revokes it, and a form that makes one. */
export function Invitations() {
  const { data: invitations, error, refetch } = useQuery(invitationsQuery);
  const [shown, more] = useFirst(invitations ?? []);
  const { data: behaviours = [] } = useQuery(behavioursQuery);
  const revoke = useMutation({ mutationFn: revokeInvitation, onSettled: () => void refetch() });
  if (error && !invitations) {
    return <Failed what={t`The invitations`} error={error} onRetry={() => void refetch()} />;
  }
  if (!invitations) return <Loading what={t`the invitations`} rows={1} height="3rem" />;
  const behaviourName = (id: number | null) =>
    behaviours.find((behaviour) => behaviour.id === id)?.name;
  return (
    <>
      {revoke.error && (
        <Notice tone="bad" live>
          {messageOf(revoke.error)}
        </Notice>
      )}
      <ul className={styles.rows}>
        {shown.map((invitation) => {
          const { id, name, role, behaviour_id: of } = invitation;
          return (
            <Credential
              key={id}
              note={<Use of={invitation} />}
              end={{
                label: t`Revoke`,
                name: t`Revoke the invitation ${name}`,
                disabled: revoke.isPending,
                onClick: () => revoke.mutate(id),
              }}
            >
              <strong>{name}</strong> ({roleName(role)}
              {of !== null && `, ${behaviourName(of) ?? ""}`})
            </Credential>
          );
        })}
      </ul>
      {more}
      <NewInvitationForm onMade={() => void refetch()} />
    </>
  );
}

/** When an invitation was made, how often it was used, and how long it is valid. */
function Use({ of: invitation }: { of: Invitation }) {
  const { n_used: used, max_uses: most, expires_at: until, created_at: made } = invitation;
  return (
    <>
      {moment(made)}, <Plural value={used} one="used once" other="used # times" />
      {most !== null && <Trans> of {most}</Trans>}
      {until !== null && <Trans>, until {moment(until)}</Trans>}
    </>
  );
}

function NewInvitationForm({ onMade }: { onMade: () => void }) {
  const { data: behaviours = [] } = useQuery(behavioursQuery);
  const draft = useDraft("invitation", {
    name: "",
    to: "",
    uses: USES.default,
    days: DAYS.default,
  });
  const { name, to, uses, days } = draft.value;
  const set = (part: Partial<typeof draft.value>) => draft.set({ ...draft.value, ...part });
  const make = useMutation({
    mutationFn: createInvitation,
    onSuccess: () => {
      set({ name: "" });
      onMade();
    },
  });
  const chosen = to || String(behaviours[0]?.id ?? RESEARCHERS);
  return (
    <form
      className={styles.form}
      onSubmit={(event) => {
        event.preventDefault();
        if (!name.trim()) return;
        const bounds = { name: name.trim(), max_uses: uses, days };
        make.mutate(
          chosen === RESEARCHERS
            ? { ...bounds, role: "researcher" }
            : { ...bounds, role: "participant", behaviour_id: Number(chosen) },
        );
      }}
    >
      <Field
        label={t`Who is invited`}
        hint={t`A note for you, such as the name of a class.`}
        error={make.error ? messageOf(make.error) : null}
      >
        {(control) => (
          <input
            {...control}
            value={name}
            maxLength={80}
            required
            onChange={(event) => set({ name: event.currentTarget.value })}
          />
        )}
      </Field>
      <Field label={t`What they may do`}>
        {(control) => (
          <select
            {...control}
            value={chosen}
            onChange={(event) => set({ to: event.currentTarget.value })}
          >
            {behaviours.map((behaviour) => (
              <option key={behaviour.id} value={behaviour.id}>
                {t`Play ${behaviour.name}`}
              </option>
            ))}
            <option value={RESEARCHERS}>{t`Everything but this page, as researchers`}</option>
          </select>
        )}
      </Field>
      <Bound
        label={t`People it lets in`}
        most={USES.most}
        value={uses}
        onChange={(next) => set({ uses: next })}
      />
      <Bound
        label={t`Days it is valid`}
        most={DAYS.most}
        value={days}
        onChange={(next) => set({ days: next })}
      />
      <Button kind="primary" type="submit" disabled={!name.trim() || make.isPending}>
        <Trans>Make a link</Trans>
      </Button>
      {make.data && <Secret value={new URL(make.data.path, location.origin).href} />}
    </form>
  );
}

interface BoundProps {
  label: string;
  most: number;
  value: number;
  onChange: (value: number) => void;
}

function Bound({ label, most, value, onChange }: BoundProps) {
  return (
    <Field label={label}>
      {(control) => (
        <input
          {...control}
          type="number"
          min={1}
          max={most}
          required
          value={Number.isNaN(value) ? "" : value}
          onChange={(event) => onChange(event.currentTarget.valueAsNumber)}
        />
      )}
    </Field>
  );
}
