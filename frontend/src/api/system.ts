import { queryOptions } from "@tanstack/react-query";

import { api, unwrap } from "./client";
import type { Player, System } from "./types";

/** Which processes are alive. Polled, since a dead process sends no event. */
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

/** Whether a worker that learns on a GPU is alive; null while unknown. */
export function hasGpu(system: System | undefined): boolean | null {
  if (!system) return null;
  return system.processes.some(
    ({ kind, alive, gpu }) => kind === "worker" && alive && gpu !== null,
  );
}

/** Whether a process of a kind is alive; null while unknown. */
export function isAlive(system: System | undefined, kind: "worker" | "inference"): boolean | null {
  if (!system) return null;
  return system.processes.some((process) => process.kind === kind && process.alive);
}
