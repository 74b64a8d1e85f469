import { QueryClientProvider } from "@tanstack/react-query";
import { act, render, screen, waitFor, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { createMemoryRouter, RouterProvider } from "react-router";
import { beforeEach, describe, expect, it, vi } from "vitest";

import { connection } from "@/api/connection";
import { createQueryClient } from "@/app/query-client";
import { routes } from "@/app/router";
import { ToastProvider } from "@/components/feedback/Toasts";

import { behaviour, recipe, results, run, system } from "../../support/data";
import { Refusal, serve } from "../../support/server";

class SilentEventSource extends EventTarget {
  close(): void {
    /* nothing was open */
  }
}

function open(path: string) {
  return openWith(path).router;
}

function openWith(path: string) {
  const client = createQueryClient();
  client.setDefaultOptions({ queries: { retry: false } });
  const router = createMemoryRouter(routes, { initialEntries: [path] });
  render(
    <QueryClientProvider client={client}>
      <ToastProvider>
        <RouterProvider router={router} />
      </ToastProvider>
    </QueryClientProvider>,
  );
  return { client, router };
}

const CALM = {
  "GET /api/behaviours": () => [behaviour({ n_recordings: 1 })],
  "GET /api/behaviours/1": () => behaviour({ n_recordings: 3 }),
  "GET /api/runs": () => [],
  "GET /api/recipes": () => [recipe()],
  "GET /api/player": () => ({ id: 1, name: "Ada", role: "owner" }),
  "GET /api/system": () => system(true),
};

beforeEach(() => {
  connection.update({ reachable: true, authorised: true, live: true });
  vi.stubGlobal("EventSource", SilentEventSource);
  vi.stubGlobal("scrollTo", () => undefined);
});

describe("every page", () => {
  it("shows who plays and whether the worker runs", async () => {
    serve(CALM);
    open("/");
    expect(await screen.findByRole("button", { name: /Player: Ada/ })).toBeVisible();
    expect(await screen.findByText("Worker ready")).toBeVisible();
  });

  it("says that the worker trains, and how far it is", async () => {
    const training = run({ id: "r1", status: "running", progress: 0.42 });
    serve({ ...CALM, "GET /api/runs": () => [training] });
    open("/");
    expect(await screen.findByText("Training, 42%")).toBeVisible();
    expect(screen.queryByText("Worker ready")).toBeNull();
  });

  it("says that nothing is known of the worker while the change stream is silent", async () => {
    serve(CALM);
    open("/");
    expect(await screen.findByText("Worker ready")).toBeVisible();
    act(() => connection.update({ live: false }));
    expect(screen.getByRole("button", { name: /^No connection/ })).toBeVisible();
    act(() => connection.update({ live: true }));
    expect(screen.getByText("Worker ready")).toBeVisible();
  });

  it("asks nothing for players that they may not know", async () => {
    const asked = serve({
      ...CALM,
      "GET /api/player": () => ({ id: 2, name: "Mia", role: "participant" }),
    });
    open("/");
    expect(await screen.findByRole("button", { name: /Player: Mia/ })).toBeVisible();
    const paths = asked.map(({ path }) => path);
    expect(paths).not.toContain("/api/system");
    expect(paths).not.toContain("/api/runs");
  });

  it.each([
    ["announces the end with the verdict", "/"],
    ["repeats nothing that the run's own page says", "/runs/r1"],
  ])("shows the progress of a run in its title, and %s", async (_, path) => {
    const shown: string[] = [];
    const Shown = Object.assign(
      function Shown(title: string, options: NotificationOptions) {
        shown.push(`${title}: ${options.body ?? ""}`);
      },
      { permission: "granted" },
    );
    vi.stubGlobal("Notification", Shown);
    localStorage.setItem("tril-notify", "on");
    const one = run({ id: "r1", progress: 0.347, behaviour_name: "Column 3" });
    let active = [one];
    serve({
      ...CALM,
      "GET /api/runs": ({ query }) => (query.has("active") ? active : []),
      "GET /api/runs/r1": () => new Refusal(404, { detail: "Not in this test.", errors: null }),
      "GET /api/runs/r1/metrics": () => ({ groups: {} }),
      "GET /api/runs/r1/results": () =>
        results(
          { ...one, status: "done" },
          {
            verdict: {
              tone: "good",
              sentence: "It plays well.",
              details: "",
              advice: "",
              next_step: null,
            },
          },
        ),
    });
    const { client, router } = openWith("/");
    await waitFor(() => expect(document.title).toBe("34% · Column 3 – Tril"));
    await act(() => router.navigate(path));
    active = [];
    await client.invalidateQueries({ queryKey: ["runs"] });
    if (path !== "/") {
      await waitFor(() => expect(shown).toHaveLength(1));
      expect(screen.queryByText("Column 3: It plays well.")).toBeNull();
      return;
    }
    expect(await screen.findByText("Column 3: It plays well.")).toBeVisible();
    expect(document.title).toBe("Tril");
    expect(shown).toEqual(["Run of Column 3 ended: It plays well."]);
    await userEvent.click(screen.getByRole("button", { name: "Look" }));
    expect(router.state.location.pathname).toBe("/runs/r1");
  });

  it("shows the processes and the disk usage", async () => {
    serve(CALM);
    open("/");
    await userEvent.click(
      await screen.findByRole("button", { name: "Worker ready. Processes and disk" }),
    );
    const dialog = within(screen.getByRole("dialog", { name: "Processes and disk" }));
    const rows = dialog.getAllByRole("row").map((row) => row.textContent);
    expect(rows).toEqual([
      "Workerlab-3, 8 coresrunning",
      "Recordings, rankings and curves200\u00a0kB",
      "Files of runs500\u00a0kB",
      "Cache of frames and clips300\u00a0kB, at most 500\u00a0MB",
      "Everything else0\u00a0B",
      "Total1.0\u00a0MB",
      "Free on the disk1.0\u00a0GB",
    ]);
  });

  it("says that a worker is busy which lives without a heartbeat", async () => {
    const { processes, ...rest } = system(true);
    const starved = processes.map((process) => ({ ...process, busy: true }));
    const queued = run({ id: "r1", status: "running", worker_alive: false });
    serve({
      ...CALM,
      "GET /api/system": () => ({ ...rest, processes: starved }),
      "GET /api/runs/r1": () => queued,
      "GET /api/runs/r1/metrics": () => ({ last: 0, series: {} }),
      "GET /api/runs/r1/results": () => results(queued),
    });
    open("/runs/r1");
    await userEvent.click(
      await screen.findByRole("button", { name: "Worker busy. Processes and disk" }),
    );
    const dialog = within(screen.getByRole("dialog", { name: "Processes and disk" }));
    expect(dialog.getAllByRole("row")[0]?.textContent).toBe("Workerlab-3, 8 coresbusy");
    expect(await screen.findByRole("button", { name: "Cancel run" })).toBeEnabled();
    expect(screen.queryByText(/The worker isn’t running/)).toBeNull();
  });

  it("lets the player change the name", async () => {
    const asked = serve({
      ...CALM,
      "PATCH /api/player": () => ({ id: 1, name: "Grace", role: "owner" }),
    });
    open("/");
    await userEvent.click(await screen.findByRole("button", { name: /Player: Ada/ }));
    await userEvent.clear(screen.getByLabelText("Name"));
    await userEvent.type(screen.getByLabelText("Name"), "Grace");
    await userEvent.click(screen.getByRole("button", { name: "Save" }));
    expect(await screen.findByRole("button", { name: /Player: Grace/ })).toBeVisible();
    expect(asked.find(({ method }) => method === "PATCH")?.body).toEqual({ name: "Grace" });
  });

  it("cycles through the themes and stores the choice", async () => {
    serve(CALM);
    open("/");
    const button = await screen.findByRole("button", { name: /^Theme/ });
    await userEvent.click(button);
    expect(document.documentElement.dataset.theme).toBe("light");
    await userEvent.click(button);
    expect(localStorage.getItem("tril.theme")).toBe("dark");
    await userEvent.click(button);
    expect(document.documentElement.dataset.theme).toBeUndefined();
  });

  it("says what to open when the browser isn't signed in", async () => {
    const refusal = () => new Refusal(401, { detail: "No cookie." });
    serve({ ...CALM, "GET /api/behaviours": refusal });
    open("/");
    expect(
      await screen.findByRole("heading", { name: "This browser isn’t signed in yet" }),
    ).toBeVisible();
    expect(screen.getByText(/Open that address once in this browser/)).toBeVisible();
    expect(screen.getByLabelText("Key, or the whole address")).toHaveAttribute("name", "token");
  });

  it("reports an unreachable server and recovers when it is back", async () => {
    vi.stubGlobal("fetch", () => Promise.reject(new TypeError("Failed to fetch")));
    open("/");
    expect(await screen.findByText("Tril’s server doesn’t answer.")).toBeVisible();
    serve(CALM);
    const banner = within(screen.getByRole("banner"));
    await userEvent.click(banner.getByRole("button", { name: "Try again" }));
    expect(await screen.findByRole("heading", { name: "Column 1" })).toBeVisible();
    await waitFor(() => expect(screen.queryByText("Tril’s server doesn’t answer.")).toBeNull());
  });

  it.each(["/nowhere", "/runs/none", "/recordings/99", "/recordings/x", "/behaviours/x"])(
    "says that there is nothing at %s",
    async (path) => {
      const none = new Refusal(422, { detail: "Input should be a valid UUID." });
      serve({ ...CALM, "GET /api/runs/none": () => none });
      open(path);
      expect(await screen.findByRole("heading", { name: "Page not found" })).toBeVisible();
      expect(screen.getByRole("link", { name: "All behaviours" })).toBeVisible();
    },
  );
});

describe("a behaviour's pages", () => {
  it("show the path, what is done and what is next", async () => {
    serve(CALM);
    open("/behaviours/1/train");
    const path = await screen.findByRole("navigation", { name: "Path" });
    const links = [...path.querySelectorAll("a")].map((link) => link.getAttribute("href"));
    expect(links).toEqual([
      "/behaviours/1/play",
      "/behaviours/1/recordings",
      "/behaviours/1/rank",
      "/behaviours/1/train",
      "/behaviours/1/runs",
    ]);
    expect(screen.getByRole("link", { name: /Play \(done\)/ })).toBeVisible();
    expect(screen.getByRole("link", { name: /Rank \(next\)/ })).toBeVisible();
    expect(screen.getByRole("link", { name: /Train/, current: "page" })).toBeVisible();
  });

  it("report an unknown behaviour", async () => {
    serve({ ...CALM, "GET /api/behaviours/7": () => new Refusal(404, { detail: "Gone." }) });
    open("/behaviours/7/play");
    expect(await screen.findByRole("heading", { name: "Behaviour not found" })).toBeVisible();
  });

  it("include those of its runs", async () => {
    const one = run({ id: "r1", status: "queued", worker_alive: false });
    serve({
      ...CALM,
      "GET /api/system": () => system(false),
      "GET /api/runs/r1": () => one,
      "GET /api/runs/r1/metrics": () => ({ last: 0, series: {} }),
      "GET /api/runs/r1/results": () => results(one),
    });
    open("/runs/r1");
    expect(await screen.findByRole("link", { name: /Look/, current: "page" })).toBeVisible();
    expect(
      await screen.findByText(/The worker isn’t running, so this run makes no progress/),
    ).toBeVisible();
    expect(screen.getByRole("button", { name: "Cancel run" })).toBeEnabled();
    expect(await screen.findByText(/Curves appear as soon as learning begins/)).toBeVisible();
  });
});
