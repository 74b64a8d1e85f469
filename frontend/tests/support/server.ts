/** A fake server: answers fetches by method and path, and records the requests. */
import { vi } from "vitest";

import { gameRoutes } from "./games";

export interface Asked {
  readonly method: string;
  readonly path: string;
  readonly query: URLSearchParams;
  readonly body: unknown;
  readonly headers: Headers;
  readonly signal: AbortSignal;
}

export class Refusal {
  readonly status: number;
  readonly body: unknown;

  constructor(status: number, body: unknown) {
    this.status = status;
    this.body = body;
  }
}

type Answer = (asked: Asked) => unknown;

/** A promise that an answer may wait for, and what resolves it. */
export function deferred() {
  let resolve: () => void = () => undefined;
  const promise = new Promise<void>((done) => {
    resolve = done;
  });
  return { promise, resolve };
}

/**
 * Replaces `fetch` by a fake server; returns the requests it receives.
 *
 * @param answers By "METHOD /path"; a `Refusal` becomes an error, `undefined` an empty 204.
 */
export function serve(answers: Readonly<Record<string, Answer>>): Asked[] {
  // Every page asks for its game.
  const known: Readonly<Record<string, Answer>> = { ...gameRoutes(), ...answers };
  const all: Asked[] = [];
  vi.stubGlobal("fetch", async (input: Request | string, init?: RequestInit) => {
    const request =
      typeof input === "string" ? new Request(new URL(input, location.href), init) : input;
    const url = new URL(request.url);
    const text = request.method === "GET" ? "" : await request.text();
    const asked = {
      method: request.method,
      path: url.pathname,
      query: url.searchParams,
      body: parsed(text),
      headers: request.headers,
      signal: request.signal,
    };
    all.push(asked);
    const answer = known[`${asked.method} ${asked.path}`];
    if (!answer) return json(404, { detail: `Nothing at ${asked.method} ${asked.path}.` });
    const given = await answer(asked);
    if (given instanceof Refusal) return json(given.status, given.body);
    if (given instanceof ArrayBuffer) return new Response(given);
    if (given instanceof Response) return given;
    return given === undefined ? new Response(null, { status: 204 }) : json(200, given);
  });
  return all;
}

function parsed(text: string): unknown {
  try {
    return JSON.parse(text) as unknown;
  } catch {
    return text;
  }
}

function json(status: number, body: unknown): Response {
  return new Response(JSON.stringify(body), {
    status,
    headers: { "Content-Type": "application/json" },
  });
}
