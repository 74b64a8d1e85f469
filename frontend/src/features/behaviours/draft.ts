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

/** The form of a copy: its name is free. */
export function copyOf(
  behaviour: Behaviour,
  others: readonly Pick<Behaviour, "id" | "name">[],
): BehaviourDraft {
  const draft = draftOf(behaviour);
  const first = t`${draft.name.slice(0, 100)} with another target`;
  let name = first;
  for (let number = 2; nameProblem(name, others); number += 1) name = `${first} (${number})`;
  return { ...draft, name, hasTarget: true };
}

/** What is wrong with the name of a behaviour; null if nothing is. */
export function nameProblem(
  name: string,
  others: readonly Pick<Behaviour, "id" | "name">[],
  besides?: number,
): string | null {
  if (!name.trim()) return t`Give the behaviour a name.`;
  const taken = others.find((one) => one.id !== besides && compared(one.name) === compared(name));
  return taken ? t`There is a behaviour named ${taken.name} already. Choose another name.` : null;
}

function compared(name: string): string {
  return name.normalize("NFKC").trim().toLowerCase();
}
