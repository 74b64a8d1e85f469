import { queryOptions } from "@tanstack/react-query";

import { api, unwrap } from "./client";
import type { Player, System } from "./types";

/** Which processes are alive. Asked again now and then: a process that dies announces nothing. */
export const systemQuery = queryOptions({
  queryKey: ["system"],
  queryFn: ({ signal }) => unwrap(api.GET("/api/system", { signal })),
  refetchInterval: 15_000,
});

export const playerQuery = queryOptions({
  queryKey: ["player"],
  queryFn: ({ signal }) => unwrap(api.GET("/api/player", { signal })),
});

export function renamePlayer(name: string): Promise<Player> {
  return unwrap(api.PATCH("/api/player", { body: { name } }));
}

/** Whether a kind of process is there; null while that isn't known. */
export function isAlive(system: System | undefined, kind: "worker" | "inference"): boolean | null {
  if (!system) return null;
  return system.processes.some((process) => process.kind === kind && process.alive);
}
