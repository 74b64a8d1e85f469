import { t } from "@lingui/core/macro";
import { useMutation, useQuery } from "@tanstack/react-query";
import { useState } from "react";

import { behavioursQuery } from "@/api/behaviours";
import { messageOf } from "@/api/client";
import { changeRole, peopleQuery } from "@/api/people";
import type { Person } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Failed, Loading, Notice } from "@/components/feedback/States";
import { useFirst } from "@/components/list/use-first";

import styles from "./PeoplePage.module.css";
import { roleName } from "./words";

const RESEARCHER = "researcher";
/** How many people are shown at a time: each has a menu of all behaviours. */
const FORMS = 20;

/** The people who were let in, with what they may do, which the owner can change. */
export function Persons() {
  const { data: people, error, refetch } = useQuery(peopleQuery);
  const [shown, more] = useFirst(people ?? [], FORMS);
  const change = useMutation({ mutationFn: changeRole, onSettled: () => void refetch() });
  if (error && !people) {
    return <Failed what={t`The people`} error={error} onRetry={() => void refetch()} />;
  }
  if (!people) return <Loading what={t`the people`} rows={1} height="3rem" />;
  return (
    <>
      {change.error && (
        <Notice tone="bad" live>
          {messageOf(change.error)}
        </Notice>
      )}
      <ul className={styles.rows}>
        {shown.map((person) => (
          <li key={person.id}>
            <span className={styles.what}>
              <strong>{person.name}</strong> <small>{roleName(person.role)}</small>
            </span>
            {person.role !== "owner" && (
              <RoleForm
                // Begins anew with what the person may do once that has changed.
                key={`${person.role} ${person.behaviour_ids.join(" ")}`}
                person={person}
                disabled={change.isPending}
                onChange={(to) => change.mutate({ id: person.id, ...to })}
              />
            )}
          </li>
        ))}
      </ul>
      {more}
    </>
  );
}

type Update = Omit<Parameters<typeof changeRole>[0], "id">;

function RoleForm({
  person,
  disabled,
  onChange,
}: {
  person: Person;
  disabled: boolean;
  onChange: (to: Update) => void;
}) {
  const { data: behaviours = [] } = useQuery(behavioursQuery);
  const { name, role, behaviour_ids: played } = person;
  const isResearcher = role === "researcher";
  const present = isResearcher ? RESEARCHER : String(played[0] ?? "");
  const [chosen, setChosen] = useState(present);
  return (
    <form
      className={styles.role}
      onSubmit={(event) => {
        event.preventDefault();
        onChange(
          chosen === RESEARCHER
            ? { role: "researcher" }
            : { role: "participant", behaviour_id: Number(chosen) },
        );
      }}
    >
      <select
        aria-label={t`What ${name} may do`}
        value={chosen}
        onChange={(event) => setChosen(event.currentTarget.value)}
      >
        {behaviours.map((behaviour) => (
          <option key={behaviour.id} value={behaviour.id}>
            {!isResearcher && played.includes(behaviour.id)
              ? t`Plays ${behaviour.name}`
              : t`Play ${behaviour.name}`}
          </option>
        ))}
        <option value={RESEARCHER}>{t`Everything but this page, as researchers`}</option>
      </select>
      <Button
        type="submit"
        aria-label={t`Change what ${name} may do`}
        disabled={disabled || chosen === present || chosen === ""}
      >
        {t`Change`}
      </Button>
    </form>
  );
}
