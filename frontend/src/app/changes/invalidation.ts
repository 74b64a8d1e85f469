/** Maps changes on the server to the queries they make stale. */
import type { QueryClient, QueryKey } from "@tanstack/react-query";

import type { Change } from "./change-stream";

/** Key prefixes of the queries that a change makes stale. */
export function staleKeys({ topic, key }: Change): QueryKey[] {
  switch (topic) {
    case "run":
      return [
        ["run", key],
        ["results", key],
        ["blind", key],
        ["metrics", key],
        ["runs"],
        ["behaviours"],
      ];
    case "recording":
      return [["recordings"], ["recording", Number(key)], ["behaviours"]];
    case "library":
      // Many recordings at once; without a key, of any behaviour.
      return [
        key === "" ? ["recordings"] : ["recordings", Number(key)],
        ["recording"],
        ["behaviours"],
      ];
    case "ranking":
      return [
        ["ranking", Number(key)],
        ["opinion", Number(key)],
        ["understanding", Number(key)],
        ["things", Number(key)],
        ["recordings", Number(key)],
        ["behaviours"],
      ];
    case "behaviour":
      return [["behaviours"]];
    case "system":
      return [["system"]];
    case "player":
      return [["player"]];
    case "access":
    case "invitation":
      return [["people"]];
    default:
      return [];
  }
}

/** A query is refetched at most once in this time, however many changes arrive. */
const COLLECT_MS = 250;

/** Collects changes for a moment, then invalidates each query once. */
export class Invalidator {
  private readonly client: QueryClient;
  private readonly pending = new Map<string, QueryKey>();
  private timer: ReturnType<typeof setTimeout> | null = null;

  constructor(client: QueryClient) {
    this.client = client;
  }

  add(change: Change): void {
    for (const key of staleKeys(change)) this.pending.set(JSON.stringify(key), key);
    this.timer ??= setTimeout(() => this.flush(), COLLECT_MS);
  }

  /** Invalidates every query. */
  all(): void {
    void this.client.invalidateQueries();
  }

  stop(): void {
    if (this.timer !== null) clearTimeout(this.timer);
    this.timer = null;
    this.pending.clear();
  }

  private flush(): void {
    const keys = [...this.pending.values()];
    this.stop();
    for (const queryKey of keys) void this.client.invalidateQueries({ queryKey });
  }
}
