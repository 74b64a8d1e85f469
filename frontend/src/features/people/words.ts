/** Words for roles and for what people did. */
import { t } from "@lingui/core/macro";

import type { AuditEntry, Player } from "@/api/types";

export function roleName(role: Player["role"]): string {
  return {
    owner: t`Owner`,
    researcher: t`Researcher`,
    participant: t`Player`,
    worker: t`Worker`,
  }[role];
}

/** Says what somebody did, with what it was done to. */
export function actionOf({ action, subject }: Pick<AuditEntry, "action" | "subject">): string {
  const said: Record<AuditEntry["action"], string> = {
    "signed in": t`signed in (${subject})`,
    "signed out": t`signed out ${subject}`,
    "signed everybody out": t`made a new key, which signed everybody out`,
    "made an invitation": t`made ${subject}`,
    "used an invitation": t`came by ${subject}`,
    "revoked an invitation": t`revoked ${subject}`,
    "made a key": t`made ${subject}`,
    "revoked a key": t`revoked ${subject}`,
    "changed a role": t`changed what ${subject} may do`,
    "let a worker in": t`let a worker in by ${subject}`,
    deleted: t`deleted ${subject}`,
    restored: t`restored ${subject}`,
    imported: t`imported ${subject}`,
    ranked: t`ranked ${subject}`,
    "queued a run": t`started ${subject}`,
    "cancelled a run": t`cancelled ${subject}`,
  };
  return said[action];
}

/** What more is known of an entry: names, and numbers such as a revision. */
export function detailsOf({ details }: Pick<AuditEntry, "details">): string {
  return Object.entries(details)
    .map(([name, value]) => `${name}: ${String(value)}`)
    .join(", ");
}
