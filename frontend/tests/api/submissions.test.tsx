import { describe, expect, it, vi } from "vitest";

import { ProblemError } from "@/api/client";
import { importRecordings } from "@/api/recordings";
import { createRun } from "@/api/runs";

import { type Asked, Refusal, serve } from "../support/server";
import { denyStorage } from "../support/storage";

const RUN = { behaviour_id: 1, recipe: "fast", steps: 1000 } as Parameters<typeof createRun>[0];

const keys = (asked: readonly Asked[]) =>
  asked.map(({ headers }) => headers.get("Idempotency-Key"));

describe("submissions", () => {
  it("are sent once while they are in flight", async () => {
    let answer: (run: unknown) => void = () => undefined;
    const asked = serve({
      "POST /api/runs": () => new Promise((resolve) => (answer = resolve)),
    });
    const both = [createRun(RUN), createRun(RUN)];
    await vi.waitFor(() => expect(asked).toHaveLength(1));
    answer({ id: "a" });
    expect(await Promise.all(both)).toEqual([{ id: "a" }, { id: "a" }]);
    expect(asked).toHaveLength(1);
  });

  it("have their key again until their outcome is known", async () => {
    const answers: unknown[] = [new Refusal(503, { detail: "Busy." }), { id: "a" }, { id: "b" }];
    const asked = serve({ "POST /api/runs": () => answers.shift() });
    await expect(createRun(RUN)).rejects.toThrow(ProblemError);
    await createRun(RUN);
    await createRun(RUN);
    const [lost, again, other] = keys(asked);
    expect(lost).toMatch(/^[0-9a-f-]{36}$/);
    expect(again).toBe(lost);
    expect(other).not.toBe(lost);
  });

  it("have their key again when the response was lost", async () => {
    const asked = serve({
      "POST /api/runs": () => {
        if (asked.length < 3) throw new TypeError("Failed to fetch");
        return { id: "a" };
      },
    });
    await expect(createRun(RUN)).rejects.toThrow();
    await expect(createRun(RUN)).rejects.toThrow();
    await createRun(RUN);
    expect(new Set(keys(asked)).size).toBe(1);
  });

  it("have other keys if their content is another, or was refused", async () => {
    const asked = serve({
      "POST /api/runs": ({ body }) =>
        (body as { steps: number }).steps < 9
          ? new Refusal(422, { detail: "No." })
          : new Refusal(500, {}),
    });
    for (const steps of [1000, 2000, 1, 1]) {
      await expect(createRun({ ...RUN, steps })).rejects.toThrow();
    }
    expect(new Set(keys(asked)).size).toBe(4);
  });

  it("are other ones after some minutes", async () => {
    vi.useFakeTimers({ toFake: ["Date"] });
    const asked = serve({ "POST /api/runs": () => new Refusal(503, {}) });
    await expect(createRun(RUN)).rejects.toThrow();
    vi.setSystemTime(Date.now() + 6 * 60_000);
    await expect(createRun(RUN)).rejects.toThrow();
    vi.useRealTimers();
    expect(new Set(keys(asked)).size).toBe(2);
  });

  it("may be uploads, and storage may be denied", async () => {
    const allow = denyStorage();
    const asked = serve({
      "POST /api/behaviours/1/recordings/import": () => new Refusal(503, { detail: "Busy." }),
    });
    const send = () => importRecordings(1, new Blob(["{}\n"]), { rank: false, perfect: false });
    await expect(send()).rejects.toThrow("Busy.");
    await expect(send()).rejects.toThrow("Busy.");
    allow();
    expect(keys(asked)[0]).toBeTruthy();
    expect(new Set(keys(asked)).size).toBe(1);
  });
});
