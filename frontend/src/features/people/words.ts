/** Words for roles and for what people did. */
import { plural, t } from "@lingui/core/macro";

import type { AuditEntry, Player } from "@/api/types";
import { shortId } from "@/lib/runs";

const roleNames = (): Readonly<Record<Player["role"], string>> => ({
  owner: t`Owner`,
  researcher: t`Researcher`,
  participant: t`Player`,
  worker: t`Worker`,
});

export function roleName(role: Player["role"]): string {
  return roleNames()[role];
}

/** Says what somebody did, with what it was done to; an unknown action as it is stored. */
export function actionOf(entry: Pick<AuditEntry, "action" | "subject" | "details">): string {
  const subject = subjectOf(entry.subject, entry.details.number);
  const said: Record<AuditEntry["action"], string> = {
    "signed in": t`signed in (${subject})`,
    "signed out": t`signed out ${subject}`,
    "signed everybody out": t`made a new key, which signed everybody out`,
    "made an invitation": t`made ${subject}`,
    "used an invitation": t`joined by ${subject}`,
    "revoked an invitation": t`revoked ${subject}`,
    "made a key": t`made ${subject}`,
    "revoked a key": t`revoked ${subject}`,
    "changed a role": t`changed what ${subject} may do`,
    "let a worker in": t`let a worker join with ${subject}`,
    deleted: t`deleted ${subject}`,
    restored: t`restored ${subject}`,
    renamed: t`renamed ${subject}`,
    changed: t`changed ${subject}`,
    "marked as perfect": t`marked ${subject} as perfect`,
    "unmarked as perfect": t`removed the perfect mark from ${subject}`,
    "wrote notes": t`wrote notes on ${subject}`,
    imported: t`imported ${subject}`,
    exported: t`exported ${subject}`,
    "backed up": t`made a backup`,
    ranked: t`ranked ${subject}`,
    "answered a statement": t`answered a statement about the ranking of ${subject}`,
    "compared games blind": t`compared games of ${subject} blind`,
    "queued a run": t`started ${subject}`,
    "cancelled a run": t`cancelled ${subject}`,
  };
  return wordFor(said, entry.action) ?? `${entry.action} ${subject}`.trim();
}

/** Names what is stored as a kind and an id: "behaviour 12"; a recording by its number. */
function subjectOf(subject: string, number?: unknown): string {
  const [kind = "", id = ""] = subject.split(" ");
  const said: Readonly<Record<string, string>> = {
    behaviour: t`behaviour ${id}`,
    browser: t`browser ${id}`,
    invitation: t`invitation ${id}`,
    key: t`key ${id}`,
    player: t`person ${id}`,
    recording: typeof number === "number" ? t`recording ${number}` : t`a recording (id ${id})`,
    run: shortId(id),
  };
  return wordFor(said, kind) ?? subject;
}

/** What more is known of an entry: names, and numbers such as a revision. */
export function detailsOf({ details }: Pick<AuditEntry, "details">): string {
  return Object.entries(details)
    .map(([name, value]) => detailOf(name, String(value)))
    .filter((detail) => detail !== "")
    .join(", ");
}

function detailOf(name: string, value: string): string {
  switch (name) {
    case "name":
    case "browser":
      return value;
    case "role":
      return t`role: ${wordFor(roleNames(), value) ?? value}`;
    case "before":
      return t`before: ${wordFor(roleNames(), value) ?? value}`;
    case "behaviour":
      return subjectOf(`${name} ${value}`);
    case "number":
      return "";
    case "recipe":
      return t`recipe: ${value}`;
    case "revision":
      return t`revision ${value}`;
    case "change":
      return wordFor(changes(), value) ?? value;
    case "recordings":
      return plural(Number(value), { one: "# recording", other: "# recordings" });
    case "browsers":
      return plural(Number(value), { one: "# browser", other: "# browsers" });
    default:
      return `${name}: ${value}`;
  }
}

/** How a ranking was changed; nothing for the ordinary way. */
const changes = (): Readonly<Record<string, string>> => ({
  edit: "",
  undo: t`undone`,
  redo: t`redone`,
  import: t`by an import`,
  example: t`from the example`,
  deletion: t`by a deletion`,
});

/** Returns the word for what is stored; undefined if this page has none. */
function wordFor(words: Readonly<Record<string, string>>, key: string): string | undefined {
  return Object.hasOwn(words, key) ? words[key] : undefined;
}
