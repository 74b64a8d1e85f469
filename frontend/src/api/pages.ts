/** Lists that the server returns in pages. */

/** Entries of a page, the most that the server returns at once. */
export const PAGE_LENGTH = 200;

/** Fetches a whole list page by page, each given the last entry of the page before it. */
export async function everyPage<T extends { readonly id: unknown }>(
  fetchPage: (last: T | undefined, limit: number) => Promise<readonly T[]>,
): Promise<T[]> {
  const entries: T[] = [];
  for (;;) {
    const page = await fetchPage(entries.at(-1), PAGE_LENGTH);
    entries.push(...page);
    if (page.length < PAGE_LENGTH) return entries;
  }
}

/** Names the last entry of the page before, for lists that begin with the oldest. */
export const after = <Id>(last: { readonly id: Id } | undefined) =>
  last === undefined ? {} : { after: last.id };

/** The same for lists that begin with the newest. */
export const before = <Id>(last: { readonly id: Id } | undefined) =>
  last === undefined ? {} : { before: last.id };
