import { queryOptions } from "@tanstack/react-query";

import { api, fetchBytes, fetchFile, patientFetch, unwrap } from "./client";
import { before, everyPage } from "./batches";
import type { Behaviour, Run, RunNew, RunUpdate } from "./types";

function at(runId: string) {
  return { params: { path: { run_id: runId } } };
}

/** The recipes that a behaviour can be trained with, the proposed one first. */
export function recipesQuery({ game, target }: Pick<Behaviour, "game" | "target">) {
  const query = { game, has_target: target !== null };
  return queryOptions({
    queryKey: ["recipes", query],
    queryFn: ({ signal }) => unwrap(api.GET("/api/recipes", { params: { query }, signal })),
  });
}

function runsThat(
  filter: { behaviour_id?: number; active?: boolean },
  signal: AbortSignal,
): Promise<Run[]> {
  return everyPage<Run>((last, limit) =>
    unwrap(
      api.GET("/api/runs", { params: { query: { ...filter, limit, ...before(last) } }, signal }),
    ),
  );
}

/** The runs of a behaviour, or of all; newest first. */
export function runsQuery(behaviourId?: number) {
  return queryOptions({
    queryKey: behaviourId === undefined ? ["runs"] : ["runs", { behaviourId }],
    queryFn: ({ signal }) =>
      runsThat(behaviourId === undefined ? {} : { behaviour_id: behaviourId }, signal),
  });
}

/** The runs that are not over. */
export const activeRunsQuery = queryOptions({
  queryKey: ["runs", { active: true }],
  queryFn: ({ signal }) => runsThat({ active: true }, signal),
});

export function runQuery(runId: string) {
  return queryOptions({
    queryKey: ["run", runId],
    queryFn: ({ signal }) => unwrap(api.GET("/api/runs/{run_id}", { ...at(runId), signal })),
  });
}

export function resultsQuery(runId: string) {
  return queryOptions({
    queryKey: ["results", runId],
    queryFn: ({ signal }) =>
      unwrap(api.GET("/api/runs/{run_id}/results", { ...at(runId), signal })),
  });
}

/** R of every observation of a recording, computed by the inference process. */
export function rewardTraceQuery(runId: string, recordingId: number) {
  return queryOptions({
    queryKey: ["reward", runId, recordingId],
    queryFn: ({ signal }) =>
      unwrap(
        api.GET("/api/runs/{run_id}/reward/{recording_id}", {
          params: { path: { run_id: runId, recording_id: recordingId } },
          signal,
          fetch: patientFetch,
        }),
      ),
    staleTime: Infinity,
    retry: false,
  });
}

export function createRun(body: RunNew): Promise<Run> {
  return unwrap(api.POST("/api/runs", { body }));
}

/** Imports the finished run that ships with Tril, once, and returns it. */
export function openExample(): Promise<Run> {
  return unwrap(api.POST("/api/example", { fetch: patientFetch }));
}

/** The server gives up making an archive after 300 s. */
const ARCHIVE_MS = 330_000;

/** What a finished run is taken away as: a zip, a page that needs no server, the page's poster. */
export type TakenAway = "archive.zip" | "page.html" | "page.png";

/** Fetches a finished run as a file; the server takes some seconds to make it the first time. */
export async function fetchTakenAway(runId: string, file: TakenAway): Promise<Blob> {
  const url = `/api/runs/${runId}/${file}`;
  return new Blob([await fetchBytes(url, undefined, ARCHIVE_MS)]);
}

export function cancelRun(runId: string): Promise<Run> {
  return unwrap(api.POST("/api/runs/{run_id}/cancel", at(runId)));
}

export function resumeRun(runId: string): Promise<Run> {
  return unwrap(api.POST("/api/runs/{run_id}/resume", at(runId)));
}

/** Changes a run's name or notes. */
export function updateRun(runId: string, body: RunUpdate): Promise<Run> {
  return unwrap(api.PATCH("/api/runs/{run_id}", { ...at(runId), body }));
}

export function deleteRun(runId: string): Promise<unknown> {
  return unwrap(api.DELETE("/api/runs/{run_id}", at(runId)));
}

export function restoreRun(runId: string): Promise<Run> {
  return unwrap(api.POST("/api/runs/{run_id}/restore", at(runId)));
}

/** How attention is mapped: by the gradient, or by patches of 3x3 pixels, as published, or 9x9. */
export type AttentionMethod = "gradient" | "occlusion" | "patches";

/** Whose attention is mapped. */
export type AttentionNetwork = "reward" | "imitator" | "clone";

export interface AttentionMapValues {
  /** 84 x 84 values, row by row. */
  readonly values: Float32Array;
  /** The number of the action that a policy would choose; null of the reward. */
  readonly action: number | null;
}

/** What a network of a run looks at in a state of a recording. */
export function attentionQuery(
  runId: string,
  recordingId: number,
  step: number,
  network: AttentionNetwork,
  method: AttentionMethod,
) {
  const query = new URLSearchParams({ step: String(step), network, method });
  const url = `/api/runs/${runId}/attention/${recordingId}?${query.toString()}`;
  return queryOptions({
    queryKey: ["attention", runId, recordingId, step, network, method],
    queryFn: async ({ signal }): Promise<AttentionMapValues> => {
      const answer = await fetchFile(url, signal);
      const action = answer.headers.get("X-Tril-Action");
      return {
        values: new Float32Array(await answer.arrayBuffer()),
        action: action === null ? null : Number(action),
      };
    },
    staleTime: Infinity,
    gcTime: 60_000,
    retry: false,
    structuralSharing: false,
  });
}
