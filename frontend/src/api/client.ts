/** The one way to the server: typed by its OpenAPI description, errors as exceptions. */
import createClient from "openapi-fetch";

import { connection } from "./connection";
import type { paths } from "./schema";

/** The server refused or failed; the message says what is wrong and what to do. */
export class ProblemError extends Error {
  override name = "ProblemError";
  readonly status: number;
  /** The whole body, for refusals that carry more than a message. */
  readonly body: unknown;

  constructor(status: number, message: string, body: unknown) {
    super(message);
    this.status = status;
    this.body = body;
  }
}

/** The server did not answer at all. */
export class UnreachableError extends Error {
  override name = "UnreachableError";

  constructor(cause: unknown) {
    super("Tril's server doesn't answer. Is `tril up` still running?", { cause });
  }
}

const GATEWAY_FAILURES = new Set([502, 504]);

/** `fetch` that keeps the connection's state and names the ways it can fail. */
export async function watchedFetch(input: Request | string, init?: RequestInit): Promise<Response> {
  let response: Response;
  try {
    response = await fetch(input, init);
  } catch (error) {
    if (error instanceof DOMException && error.name === "AbortError") throw error;
    connection.update({ reachable: false });
    throw new UnreachableError(error);
  }
  connection.update({ reachable: !GATEWAY_FAILURES.has(response.status) });
  if (response.status === 401) connection.update({ authorised: false });
  return response;
}

export const api = createClient<paths>({
  baseUrl: globalThis.location.origin,
  fetch: watchedFetch,
});

interface Answer<T> {
  readonly data?: T;
  readonly error?: unknown;
  readonly response: Response;
}

/** The answer's data, or the problem as an exception. */
export async function unwrap<T>(call: Promise<Answer<T>>): Promise<T> {
  const { data, error, response } = await call;
  if (!response.ok) throw problemOf(response, error);
  return data as T;
}

/** Fetches a file such as a recording's frames. */
export async function fetchBytes(url: string, signal?: AbortSignal): Promise<ArrayBuffer> {
  const response = await watchedFetch(url, { signal: signal ?? null });
  if (!response.ok) throw problemOf(response, await bodyOf(response));
  return response.arrayBuffer();
}

/** Reads an answer's JSON body, or nothing where it has none. */
export async function bodyOf(response: Response): Promise<unknown> {
  try {
    return (await response.json()) as unknown;
  } catch {
    return null; // no JSON: the status alone says what happened
  }
}

/** The exception for an answer that is no success. */
export function problemOf(response: Response, body: unknown): ProblemError {
  const detail = detailOf(body) ?? fallback(response.status);
  return new ProblemError(response.status, detail, body);
}

function detailOf(body: unknown): string | null {
  if (typeof body !== "object" || body === null || !("detail" in body)) return null;
  return typeof body.detail === "string" ? body.detail : null;
}

function fallback(status: number): string {
  if (status === 401) return "This browser isn't let in. Open the address that Tril printed.";
  if (status === 404) return "This doesn't exist (any more).";
  if (status === 413) return "The file is too large.";
  return `The server failed (${status}). Its log in the terminal says why.`;
}

/** What an exception says to the person. */
export function messageOf(error: unknown): string {
  return error instanceof Error ? error.message : "Something went wrong. Reload the page.";
}

/** Whether an exception says that a thing isn't there. */
export function isNotFound(error: unknown): boolean {
  return error instanceof ProblemError && error.status === 404;
}
