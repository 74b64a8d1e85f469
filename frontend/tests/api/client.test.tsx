import { afterEach, describe, expect, it, vi } from "vitest";

import { api, fetchBytes, fetchNamedFile, isPassing, unwrap } from "@/api/client";
import { connection } from "@/api/connection";

/** Time limits that the test lets expire. */
const limits: { ms: number; expire: () => void }[] = [];

function neverAnswer(): void {
  vi.spyOn(AbortSignal, "timeout").mockImplementation((ms) => {
    const controller = new AbortController();
    limits.push({
      ms,
      expire: () => controller.abort(new DOMException("timed out", "TimeoutError")),
    });
    return controller.signal;
  });
  vi.stubGlobal("fetch", (_input: Request | string, { signal }: RequestInit) => {
    return new Promise((_resolve, reject) => {
      signal?.addEventListener("abort", () => reject(signal.reason as Error));
    });
  });
}

afterEach(() => {
  limits.length = 0;
  vi.restoreAllMocks();
  connection.update({ reachable: true });
});

describe("a request that is never answered", () => {
  it.each([
    ["a query", () => unwrap(api.GET("/api/system")), 30_000],
    ["a change", () => unwrap(api.POST("/api/example")), 30_000],
    ["a file", () => fetchBytes("/api/recordings/1/frames"), 150_000],
  ])("ends: %s", async (_name, ask, ms) => {
    neverAnswer();
    const failed = ask().catch((error: unknown) => error);
    await vi.waitFor(() => expect(limits).toHaveLength(1));
    expect(limits[0]?.ms).toBe(ms);
    limits[0]?.expire();
    const error = await failed;
    expect(error).toMatchObject({ name: "UnreachableError" });
    expect(isPassing(error)).toBe(true);
    expect(connection.snapshot().reachable).toBe(false);
  });

  it("may be cancelled, which says nothing of the server", async () => {
    neverAnswer();
    const cancel = new AbortController();
    const failed = unwrap(api.GET("/api/system", { signal: cancel.signal })).catch(
      (error: unknown) => error,
    );
    await vi.waitFor(() => expect(limits).toHaveLength(1));
    cancel.abort();
    expect(await failed).toMatchObject({ name: "AbortError" });
    expect(connection.snapshot().reachable).toBe(true);
  });
});

describe("a body that stops coming", () => {
  it("is a server that can't be reached", async () => {
    const body = new ReadableStream({
      start: (controller) => controller.error(new DOMException("timed out", "TimeoutError")),
    });
    vi.stubGlobal("fetch", () => Promise.resolve(new Response(body)));
    await expect(fetchBytes("/api/recordings/1/frames")).rejects.toMatchObject({
      name: "UnreachableError",
    });
  });
});

describe("a named file", () => {
  it.each([
    ["the server", { "Content-Disposition": 'attachment; filename="left-3.gif"' }, "left-3.gif"],
    ["its path where the server gives no name", {}, "clip.gif"],
  ])("is named by %s", async (_case, disposition, name) => {
    const headers = new Headers({ "Content-Type": "image/gif", ...disposition });
    vi.stubGlobal("fetch", () => Promise.resolve(new Response("GIF89a", { headers })));
    const file = await fetchNamedFile("/api/recordings/3/clip.gif?v=1");
    expect(file.name).toBe(name);
    expect(file.type).toBe("image/gif");
    expect(file.size).toBe(6);
  });
});
