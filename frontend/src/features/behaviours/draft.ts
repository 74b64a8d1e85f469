/** A behaviour as a form has it. */

import { t } from "@lingui/core/macro";

import type { Behaviour } from "@/api/types";
import type { Cell } from "@/lib/game/aliens";

export interface BehaviourDraft {
  readonly name: string;
  readonly description: string;
  readonly hasTarget: boolean;
  readonly target: readonly Cell[];
  readonly ordered: boolean;
}

export const EMPTY_DRAFT: BehaviourDraft = {
  name: "",
  description: "",
  hasTarget: false,
  target: [],
  ordered: false,
};

/** The form of an existing behaviour. */
export function draftOf({ name, description, target, ordered }: Behaviour): BehaviourDraft {
  const cells = (target ?? []).map(([row, column]) => [row, column] as const);
  return { name, description, hasTarget: target !== null, target: cells, ordered };
}

type Named = Pick<Behaviour, "id" | "name">;

/** As the server has it, in characters. */
const MAX_NAME_LENGTH = 120;

/** The form of a copy: its name is free. */
export function copyOf(behaviour: Behaviour, others: readonly Named[]): BehaviourDraft {
  const draft = draftOf(behaviour);
  // Leaves room for the other words and a number.
  const first = t`${draft.name.slice(0, 90)} with another target`;
  let name = first;
  for (let number = 2; namesake(name, others); number += 1) name = `${first} (${number})`;
  return { ...draft, name, hasTarget: true };
}

/** What is wrong with the name of a behaviour; null if nothing is. */
export function nameProblem(
  name: string,
  others: readonly Named[],
  besides?: number,
): string | null {
  const length = Array.from(name.trim()).length;
  if (length === 0) return t`Give the behaviour a name.`;
  if (length > MAX_NAME_LENGTH)
    return t`Use at most ${MAX_NAME_LENGTH} characters; these are ${length}.`;
  const taken = namesake(name, others, besides);
  return taken ? t`There is a behaviour named ${taken.name} already. Choose another name.` : null;
}

/** Returns the behaviour that has a name already. */
function namesake(name: string, others: readonly Named[], besides?: number): Named | undefined {
  return others.find((one) => one.id !== besides && compared(one.name) === compared(name));
}

function compared(name: string): string {
  return name.normalize("NFKC").trim().toLowerCase();
}
