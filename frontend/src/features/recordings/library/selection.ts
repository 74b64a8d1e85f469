/** Pure functions for the selection in a list of recordings. */

interface Selection {
  readonly ids: ReadonlySet<number>;
  /** The last one toggled, where a range begins. */
  readonly anchor: number | null;
}

export const NOTHING: Selection = { ids: new Set(), anchor: null };

/**
 * Toggles a recording; with `range`, sets all from the last one toggled to the same state.
 *
 * @param shown Ids in display order.
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

/** Returns the selected ids that are shown, in display order: hidden ones are never affected. */
export function selectedOf(selection: Selection, shown: readonly number[]): number[] {
  return shown.filter((id) => selection.ids.has(id));
}
