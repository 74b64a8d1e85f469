import { queryOptions } from "@tanstack/react-query";

import { RecordedFrames } from "@/lib/game/codec";

import {
  api,
  bodyOf,
  fetchBytes,
  fetchNamedFile,
  PATIENT_MS,
  problemOf,
  trackedFetch,
  unwrap,
} from "./client";
import type { ImportResult, Recording, RecordingsChange, RecordingUpdate } from "./types";

/** The games of a behaviour that ended and were neither kept nor discarded, newest first. */
export function undecidedQuery(behaviourId: number) {
  return queryOptions({
    queryKey: ["recordings", behaviourId, "undecided"],
    queryFn: ({ signal }) =>
      unwrap(
        api.GET("/api/behaviours/{behaviour_id}/recordings", {
          params: { path: { behaviour_id: behaviourId }, query: { undecided: true } },
          signal,
        }),
      ),
  });
}

/** One recording, deleted or not. */
export function recordingQuery(recordingId: number) {
  return queryOptions({
    queryKey: ["recording", recordingId],
    queryFn: ({ signal }) =>
      unwrap(api.GET("/api/recordings/{recording_id}", { ...at(recordingId), signal })),
  });
}

/** The action of every frame of a recording, and the recordings it is related to. */
export function courseQuery(recordingId: number) {
  return queryOptions({
    queryKey: ["recording", recordingId, "course"],
    queryFn: ({ signal }) =>
      unwrap(api.GET("/api/recordings/{recording_id}/course", { ...at(recordingId), signal })),
  });
}

/** The RAM at every frame, from the URL that a course names. Immutable. */
export function memoryQuery(url: string) {
  return queryOptions({
    queryKey: ["memory", url],
    queryFn: async ({ signal }) => new Uint8Array(await fetchBytes(url, signal)),
    staleTime: Infinity,
    gcTime: 60_000,
    structuralSharing: false,
  });
}

/** The screens of a recording. Immutable: the URL carries a version. */
export function framesQuery(recording: Pick<Recording, "frames_url">) {
  return queryOptions({
    queryKey: ["frames", recording.frames_url],
    queryFn: async ({ signal }) =>
      new RecordedFrames(await fetchBytes(recording.frames_url, signal)),
    staleTime: Infinity,
    gcTime: 60_000,
    structuralSharing: false,
  });
}

function at(recordingId: number) {
  return { params: { path: { recording_id: recordingId } } };
}

export function updateRecording(recordingId: number, body: RecordingUpdate): Promise<Recording> {
  return unwrap(api.PATCH("/api/recordings/{recording_id}", { ...at(recordingId), body }));
}

export function keepRecording(recordingId: number): Promise<Recording> {
  return unwrap(api.POST("/api/recordings/{recording_id}/keep", at(recordingId)));
}

export function discardRecording(recordingId: number): Promise<Recording> {
  return unwrap(api.POST("/api/recordings/{recording_id}/discard", at(recordingId)));
}

export function restoreRecording(recordingId: number): Promise<Recording> {
  return unwrap(api.POST("/api/recordings/{recording_id}/restore", at(recordingId)));
}

export function deleteRecording(recordingId: number): Promise<unknown> {
  return unwrap(api.DELETE("/api/recordings/{recording_id}", at(recordingId)));
}

/** Applies one change to several recordings, atomically. */
export function changeRecordings(behaviourId: number, body: RecordingsChange): Promise<unknown> {
  return unwrap(
    api.POST("/api/behaviours/{behaviour_id}/recordings/change", {
      params: { path: { behaviour_id: behaviourId } },
      body,
    }),
  );
}

interface ImportOptions {
  /** Rank the recordings in the file's order, best first. */
  readonly rank: boolean;
  /** Mark all of them as perfect. */
  readonly perfect: boolean;
}

/** Uploads a file of recordings: one JSON object, or one per line. */
export async function importRecordings(
  behaviourId: number,
  file: Blob,
  { rank, perfect }: ImportOptions,
): Promise<ImportResult> {
  const query = new URLSearchParams({ rank: String(rank), perfect: String(perfect) });
  const response = await trackedFetch(
    `/api/behaviours/${behaviourId}/recordings/import?${query.toString()}`,
    { method: "POST", body: file, headers: { "Content-Type": "application/x-ndjson" } },
    PATIENT_MS,
  );
  const body = await bodyOf(response);
  if (!response.ok) throw problemOf(response, body);
  return body as ImportResult;
}

/** URL of a behaviour's recordings, or of some of them, as JSON Lines. */
export function exportUrl(behaviourId: number, only: readonly number[] = []): string {
  const query = new URLSearchParams(only.map((id) => ["recording", String(id)]));
  const path = `/api/behaviours/${behaviourId}/recordings/export`;
  return only.length === 0 ? path : `${path}?${query.toString()}`;
}

/** The server's limit on recordings that the address of an export names. */
export const MOST_IN_URL = 500;

/** Fetches some of a behaviour's recordings as JSON Lines, more than an address can name. */
export async function fetchExport(behaviourId: number, ids: readonly number[]): Promise<Blob> {
  const response = await trackedFetch(exportUrl(behaviourId), {
    method: "POST",
    body: JSON.stringify({ recording_ids: ids }),
    headers: { "Content-Type": "application/json" },
  });
  if (!response.ok) throw problemOf(response, await bodyOf(response));
  return response.blob();
}

/** URL of one recording in the exchange format. */
export function recordingExportUrl(recordingId: number): string {
  return `/api/recordings/${recordingId}/export`;
}

export type ClipKind = "gif" | "webp" | "mp4";

/** Fetches a recording as a clip; the server takes seconds to encode it the first time. */
export function fetchClip(recording: Recording, kind: ClipKind): Promise<File> {
  return fetchNamedFile(clipUrl(recording, kind));
}

function clipUrl({ id, frames_url }: Recording, kind: ClipKind): string {
  // A clip is made from the frames, so it shares their version.
  const version = new URL(frames_url, location.origin).searchParams.get("v") ?? "";
  return `/api/recordings/${id}/clip.${kind}?${new URLSearchParams({ v: version }).toString()}`;
}
