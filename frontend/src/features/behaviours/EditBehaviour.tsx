import { t } from "@lingui/core/macro";
import { Suspense, useState } from "react";

import type { Behaviour } from "@/api/types";
import { IconButton } from "@/components/controls/Button";
import { onDemand } from "@/lib/on-demand";

import type { Editing } from "./EditDialogs";

const EditDialogs = onDemand(async () => (await import("./EditDialogs")).EditDialogs);

/** The buttons that edit, copy or delete a behaviour, with their dialogs. */
export function EditBehaviour({ behaviour }: { behaviour: Behaviour }) {
  const [editing, setEditing] = useState<Editing | null>(null);
  return (
    <>
      <IconButton icon="edit" label={t`Edit the behaviour`} onClick={() => setEditing("edit")} />
      <IconButton icon="eye" label={t`What learning sees`} onClick={() => setEditing("hidden")} />
      {editing && (
        <Suspense>
          <EditDialogs behaviour={behaviour} editing={editing} onEdit={setEditing} />
        </Suspense>
      )}
    </>
  );
}
