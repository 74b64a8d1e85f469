import { t } from "@lingui/core/macro";
import { useState } from "react";

import type { Behaviour } from "@/api/types";
import { IconButton } from "@/components/controls/Button";
import { useToast } from "@/components/feedback/Toasts";
import { onDemand } from "@/lib/on-demand";

import type { Editing } from "./EditDialogs";

const EditDialogs = onDemand(async () => (await import("./EditDialogs")).EditDialogs);

/** The buttons that edit, copy or delete a behaviour, with their dialogs. */
export function EditBehaviour({ behaviour }: { behaviour: Behaviour }) {
  const [editing, setEditing] = useState<Editing | null>(null);
  const toast = useToast();
  const open = (what: Editing) =>
    void EditDialogs.load().then(
      () => setEditing(what),
      () => toast(t`This could not be loaded. Reload the page, and try again.`),
    );
  return (
    <>
      <IconButton icon="edit" label={t`Edit the behaviour`} onClick={() => open("edit")} />
      <IconButton icon="eye" label={t`What learning sees`} onClick={() => open("hidden")} />
      {editing && <EditDialogs behaviour={behaviour} editing={editing} onEdit={setEditing} />}
    </>
  );
}
