import { useMutation, useQueryClient } from "@tanstack/react-query";
import { type SubmitEvent, useState } from "react";
import { useNavigate } from "react-router";

import { behavioursQuery, createBehaviour } from "@/api/behaviours";
import { messageOf } from "@/api/client";
import { Button } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
import { Checkbox, Field } from "@/components/controls/Field";
import { Notice } from "@/components/feedback/States";
import type { Cell } from "@/lib/game/aliens";

import { AlienPicker } from "./AlienPicker";
import styles from "./NewBehaviourDialog.module.css";

/** Creates a behaviour: name, description and optionally a target. */
export function NewBehaviourDialog({ onClose }: { onClose: () => void }) {
  const client = useQueryClient();
  const navigate = useNavigate();
  const [name, setName] = useState("");
  const [description, setDescription] = useState("");
  const [hasTarget, setHasTarget] = useState(false);
  const [target, setTarget] = useState<readonly Cell[]>([]);
  const [ordered, setOrdered] = useState(false);
  const [missing, setMissing] = useState<string | null>(null);

  const create = useMutation({
    mutationFn: createBehaviour,
    onSuccess: async (behaviour) => {
      await client.invalidateQueries({ queryKey: behavioursQuery.queryKey });
      await navigate(`/behaviours/${behaviour.id}/play`);
    },
  });

  function submit(event: SubmitEvent) {
    event.preventDefault();
    if (!name.trim()) {
      setMissing("Give the behaviour a name.");
      return;
    }
    setMissing(null);
    create.mutate({
      name: name.trim(),
      description: description.trim(),
      target: hasTarget ? target.map(([row, column]) => [row, column]) : null,
      ordered: hasTarget && ordered,
    });
  }

  return (
    <Dialog title="New behaviour" onClose={onClose}>
      <form className={styles.form} onSubmit={submit} noValidate>
        <Field label="Name" error={missing}>
          {(control) => (
            <input
              {...control}
              value={name}
              maxLength={120}
              placeholder="Stay on the left"
              onChange={(event) => setName(event.currentTarget.value)}
            />
          )}
        </Field>
        <Field label="Description" hint="What a perfect game looks like, in a sentence or two.">
          {(control) => (
            <textarea
              {...control}
              rows={3}
              value={description}
              maxLength={2000}
              onChange={(event) => setDescription(event.currentTarget.value)}
            />
          )}
        </Field>
        <div className={styles.target}>
          <Checkbox
            label="Target certain aliens"
            hint="Hits and strays are then counted. The agent never sees this: it learns from your ranking and your perfect games."
            checked={hasTarget}
            onChange={setHasTarget}
          />
          {hasTarget && (
            <>
              <AlienPicker value={target} onChange={setTarget} ordered={ordered} />
              <Checkbox
                label="The order matters"
                hint="They are to be hit in the order in which you pick them."
                checked={ordered}
                onChange={setOrdered}
              />
            </>
          )}
        </div>
        {create.error && (
          <Notice tone="bad" live>
            <p>{messageOf(create.error)}</p>
          </Notice>
        )}
        <div className={styles.actions}>
          <Button kind="primary" type="submit" disabled={create.isPending}>
            {create.isPending ? "Creating…" : "Create behaviour"}
          </Button>
          <Button kind="quiet" onClick={onClose}>
            Cancel
          </Button>
        </div>
      </form>
    </Dialog>
  );
}
