import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useMutation, useQueryClient } from "@tanstack/react-query";
import { useLayoutEffect, useRef, useState } from "react";

import { api, messageOf, unwrap } from "@/api/client";
import type { NamedThing } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Field } from "@/components/controls/Field";

import styles from "./PointDialog.module.css";
import { thingsQuery } from "./things";

interface ThingNameFormProps {
  behaviourId: number;
  thing: NamedThing;
  onClose: () => void;
}

const MAX_LENGTH = 40;

/** Names a thing: what Tril says of it from then on has this name. */
export function ThingNameForm({ behaviourId, thing, onClose }: ThingNameFormProps) {
  const client = useQueryClient();
  const input = useRef<HTMLInputElement>(null);
  // The person is about to type.
  useLayoutEffect(() => input.current?.focus(), []);
  const [name, setName] = useState(thing.given ?? "");
  const { mutate, isPending, error } = useMutation({
    mutationFn: () =>
      unwrap(
        api.PUT("/api/behaviours/{behaviour_id}/ranking/things/names", {
          params: { path: { behaviour_id: behaviourId } },
          body: { key: thing.key, name: name.trim() },
        }),
      ),
    onSuccess: async (named) => {
      client.setQueryData(thingsQuery(behaviourId).queryKey, named);
      onClose();
      // Other behaviours of the game hear of it by the event stream.
      await client.invalidateQueries({ queryKey: ["understanding", behaviourId] });
    },
  });
  return (
    <form
      className={styles.naming}
      onSubmit={(event) => {
        event.preventDefault();
        if (!isPending) mutate();
      }}
    >
      <Field
        label={t`Name`}
        hint={
          thing.given === null
            ? t`For example “ball”. All behaviours of this game share the name.`
            : t`Leave it empty to use Tril’s own name. All behaviours of this game share the name.`
        }
        error={error && messageOf(error)}
      >
        {(control) => (
          <input
            {...control}
            ref={input}
            value={name}
            maxLength={MAX_LENGTH}
            onChange={(event) => setName(event.currentTarget.value)}
            onKeyDown={(event) => {
              if (event.key !== "Escape") return;
              // The dialog stays.
              event.preventDefault();
              onClose();
            }}
          />
        )}
      </Field>
      <div className={styles.buttons}>
        <Button kind="primary" type="submit" aria-disabled={isPending}>
          <Trans>Save</Trans>
        </Button>
        <Button onClick={onClose}>
          <Trans>Cancel</Trans>
        </Button>
      </div>
    </form>
  );
}
