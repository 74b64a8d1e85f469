/** Which recordings are selected on the page that is led to, as the history's state says it. */
interface Selecting {
  readonly selected: readonly number[];
}

/** Returns the state to navigate with, so that these recordings are selected there. */
export function selecting(ids: readonly number[]): Selecting {
  return { selected: ids };
}

/** Returns the recordings that a state of the history says are to be selected. */
export function selectedBy(state: unknown): readonly number[] {
  if (typeof state !== "object" || state === null || !("selected" in state)) return [];
  const { selected } = state;
  return Array.isArray(selected) ? selected.filter((id) => typeof id === "number") : [];
}
