/** The HTTP client: typed by the server's OpenAPI document, errors raised as exceptions. */
import { t } from "@lingui/core/macro";
import createClient from "openapi-fetch";

import { connection } from "./connection";
import type { paths } from "./schema";
import { submit } from "./submissions";

/** An error response; its message says what is wrong and what to do. */
export class ProblemError extends Error {
  override name = "ProblemError";
  readonly status: number;
  /** The parsed body, for errors that carry more than a message. */
  readonly body: unknown;

  constructor(status: number, message: string, body: unknown) {
    super(message);
    this.status = status;
    this.body = body;
  }
}

/** The server could not be reached. */
class UnreachableError extends Error {
  override name = "UnreachableError";

  constructor(cause: unknown) {
    super(t`Tril’s server doesn’t answer. Is \`tril up\` still running?`, { cause });
  }
}

const GATEWAY_FAILURES = new Set([502, 504]);

/** Longest time of a request; those for which the server takes a slot wait up to 20 s for it. */
const TIME_LIMIT_MS = 30_000;
/** The same of requests that replay, ask a network or upload, which wait up to 120 s. */
export const PATIENT_MS = 150_000;

/**
 * Fetches and records in `connection` whether the server is reachable and accepts this browser. A
 * POST that is repeated before its outcome is known is done once.
 *
 * @throws {UnreachableError} The server did not answer in time.
 */
export function trackedFetch(
  input: Request | string,
  init?: RequestInit,
  limitMs = TIME_LIMIT_MS,
): Promise<Response> {
  const method = typeof input === "string" ? init?.method : input.method;
  if (method !== "POST") return fetchOnce(input, init, limitMs);
  const url = typeof input === "string" ? new URL(input, location.href) : input;
  return submit(new Request(url, init), (request) => fetchOnce(request, undefined, limitMs));
}

async function fetchOnce(
  input: Request | string,
  init: RequestInit | undefined,
  limitMs: number,
): Promise<Response> {
  const given = init?.signal ?? (input instanceof Request ? input.signal : null);
  const limit = AbortSignal.timeout(limitMs);
  const signal = given ? AbortSignal.any([given, limit]) : limit;
  const response = await received(fetch(input, { ...init, signal }));
  connection.update({ reachable: !GATEWAY_FAILURES.has(response.status) });
  if (response.status === 401) connection.update({ authorised: false });
  return response;
}

/** A fetch for requests that the server may take minutes for. */
export const patientFetch = (request: Request) => trackedFetch(request, undefined, PATIENT_MS);

/** Waits for a response or its body, either of which may be cut off. */
async function received<T>(answer: Promise<T>): Promise<T> {
  try {
    return await answer;
  } catch (error) {
    const { name } = error as Error;
    // Aborted by whoever asked, or already classified.
    if (name === "AbortError" || name === "UnreachableError") throw error;
    connection.update({ reachable: false });
    throw new UnreachableError(error);
  }
}

export const api = createClient<paths>({
  baseUrl: globalThis.location.origin,
  fetch: (request) => trackedFetch(request),
});

interface Answer<T> {
  readonly data?: T;
  readonly error?: unknown;
  readonly response: Response;
}

/** Returns a response's data; throws a ProblemError if it is an error. */
export async function unwrap<T>(call: Promise<Answer<T>>): Promise<T> {
  const { data, error, response } = await received(call);
  if (!response.ok) throw problemOf(response, error);
  return data as T;
}

/** Fetches a binary file, such as a recording's frames. */
export async function fetchBytes(
  url: string,
  signal?: AbortSignal,
  limitMs = PATIENT_MS,
): Promise<ArrayBuffer> {
  return received((await fetchFile(url, signal, limitMs)).arrayBuffer());
}

/** Fetches a file whose headers matter, too; throws a ProblemError if it is an error. */
export async function fetchFile(
  url: string,
  signal?: AbortSignal,
  limitMs = PATIENT_MS,
): Promise<Response> {
  // The page's words come first.
  const response = await trackedFetch(url, { signal: signal ?? null, priority: "low" }, limitMs);
  if (!response.ok) throw problemOf(response, await bodyOf(response));
  return response;
}

/** Fetches a file under the name that the server gives it, or else the last part of its path. */
export async function fetchNamedFile(url: string): Promise<File> {
  const response = await fetchFile(url);
  const { pathname } = new URL(url, location.href);
  const name = fileNameOf(response) ?? pathname.slice(pathname.lastIndexOf("/") + 1);
  const type = response.headers.get("Content-Type") ?? "";
  return new File([await received(response.arrayBuffer())], name, { type });
}

/** The file name in a response's Content-Disposition header, which the server quotes, or null. */
function fileNameOf(response: Response): string | null {
  const disposition = response.headers.get("Content-Disposition") ?? "";
  return /;\s*filename="([^"]+)"/i.exec(disposition)?.[1] ?? null;
}

/** Parses a response's JSON body; null if it has none. */
export async function bodyOf(response: Response): Promise<unknown> {
  try {
    return (await response.json()) as unknown;
  } catch {
    return null;
  }
}

/** Builds the exception for an error response. */
export function problemOf(response: Response, body: unknown): ProblemError {
  const detail = detailOf(body) ?? fallback(response.status);
  return new ProblemError(response.status, detail, body);
}

function detailOf(body: unknown): string | null {
  if (typeof body !== "object" || body === null || !("detail" in body)) return null;
  return typeof body.detail === "string" ? body.detail : null;
}

function fallback(status: number): string {
  if (status === 401) return t`This browser isn’t signed in. Open the address that Tril printed.`;
  if (status === 404) return t`This doesn’t exist, or was deleted.`;
  if (status === 413) return t`The file is too large.`;
  return t`The server failed (${status}). Its log in the terminal says why.`;
}

/** Returns the message of an exception to show to the user. */
export function messageOf(error: unknown): string {
  return error instanceof Error ? error.message : t`Something went wrong. Reload the page.`;
}

/** Returns what an exception says of one field of a form; null if it is not about that field. */
export function fieldMessageOf(error: unknown, field: string): string | null {
  if (!(error instanceof ProblemError)) return null;
  const { errors } = (error.body ?? {}) as { errors?: readonly FieldProblem[] | null };
  const found = errors?.find(({ where }) => where.at(-1) === field);
  return found?.what ?? null;
}

interface FieldProblem {
  readonly where: readonly string[];
  readonly what: string;
}

/** Whether an exception may pass by itself: no connection, or a server that is busy or restarts. */
export function isPassing(error: unknown): boolean {
  return error instanceof ProblemError ? error.status >= 500 : error instanceof UnreachableError;
}

/** Whether what was read does not exist, or can't: 422 says that its id is none. */
export function isNotFound(error: unknown): boolean {
  return error instanceof ProblemError && (error.status === 404 || error.status === 422);
}
