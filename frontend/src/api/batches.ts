/** Requests for many things: what is asked for one by one, collected, and lists in pages. */

/** How long requests are collected: what one rendering asks for comes within a moment. */
const COLLECT_MS = 10;

interface Asked<T> {
  readonly id: number;
  readonly signal: AbortSignal;
  readonly resolve: (answer: T) => void;
  readonly reject: (reason: unknown) => void;
}

/**
 * Returns a function that fetches one thing, many of which are fetched at once.
 *
 * @param fetchMany Fetches things; what it resolves to returns one of them, or throws.
 * @param most How many may be fetched at once.
 */
export function inBatches<T>(
  fetchMany: (ids: readonly number[]) => Promise<(id: number) => T>,
  most: number,
): (id: number, signal: AbortSignal) => Promise<T> {
  let waiting: Asked<T>[] = [];

  function send() {
    // What was scrolled past meanwhile is not fetched.
    const asked = waiting.filter(({ signal }) => !signal.aborted);
    waiting = [];
    for (let start = 0; start < asked.length; start += most)
      void answerAll(asked.slice(start, start + most));
  }

  async function answerAll(asked: readonly Asked<T>[]) {
    try {
      const of = await fetchMany([...new Set(asked.map(({ id }) => id))]);
      for (const { id, resolve, reject } of asked) {
        try {
          resolve(of(id));
        } catch (error) {
          reject(error);
        }
      }
    } catch (error) {
      for (const { reject } of asked) reject(error);
    }
  }

  return (id, signal) =>
    new Promise<T>((resolve, reject) => {
      if (waiting.length === 0) setTimeout(send, COLLECT_MS);
      waiting.push({ id, signal, resolve, reject });
      signal.addEventListener("abort", () => reject(signal.reason as Error), { once: true });
    });
}

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
