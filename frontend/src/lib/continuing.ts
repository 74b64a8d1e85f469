/** The run that the next one is to continue, as the addresses of the pages up to its start name it. */

const PARAMETERS = ["continue", "steps"] as const;

/** Returns what a page's address says of the run to continue, to lead on with. */
export function continuing(search: URLSearchParams): URLSearchParams {
  const kept = new URLSearchParams();
  if (!search.has("continue")) return kept;
  for (const name of PARAMETERS) {
    const value = search.get(name);
    if (value !== null) kept.set(name, value);
  }
  return kept;
}

/** Returns the address of a page with parameters, without a question mark if there are none. */
export function withSearch(path: string, search: URLSearchParams): string {
  return search.size === 0 ? path : `${path}?${search.toString()}`;
}
