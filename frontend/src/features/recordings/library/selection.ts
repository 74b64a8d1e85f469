/** Which recordings are selected, as pure functions on the list that is shown. */

export interface Selection {
  readonly ids: ReadonlySet<number>;
  /** The one pressed last: where a range begins. */
  readonly anchor: number | null;
}

export const NOTHING: Selection = { ids: new Set(), anchor: null };

/**
 * Takes one in or out; with `range`, all from the one pressed last to this one become like it.
 *
 * @param shown Ids in the order in which they are shown.
 */
export function toggled(
  { ids, anchor }: Selection,
  shown: readonly number[],
  id: number,
  range: boolean,
): Selection {
  const next = new Set(ids);
  const on = !ids.has(id);
  const from = anchor === null ? -1 : shown.indexOf(anchor);
  const to = shown.indexOf(id);
  const among = range && from >= 0 ? shown.slice(Math.min(from, to), Math.max(from, to) + 1) : [id];
  for (const one of among) {
    if (on) next.add(one);
    else next.delete(one);
  }
  return { ids: next, anchor: id };
}

/** The selected ones that are shown, in the order shown: nothing happens to what isn't seen. */
export function selectedOf(selection: Selection, shown: readonly number[]): number[] {
  return shown.filter((id) => selection.ids.has(id));
}
