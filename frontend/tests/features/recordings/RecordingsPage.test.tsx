import { screen, waitFor, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { describe, expect, it, vi } from "vitest";

import type { Recording } from "@/api/types";
import { Invalidator } from "@/app/changes/invalidation";
import { RecordingsPage } from "@/features/recordings/RecordingsPage";

import { behaviour, recording } from "../../support/data";
import { libraryOf, libraryRoutes, partOf } from "../../support/library";
import { show } from "../../support/page";
import { deferred, Refusal, serve } from "../../support/server";

function library(list: Recording[], more: Parameters<typeof serve>[0] = {}, path = "/") {
  const asked = serve({ ...libraryRoutes(() => list), ...more });
  const page = <RecordingsPage behaviour={behaviour({ n_recordings: list.length })} />;
  return { asked, ...show(page, path) };
}

describe("the library", () => {
  it("says how each game went, who played it and whether it is verified", async () => {
    library([
      recording({ id: 5, targets: 2, strays: 1, end: "hit", n_frames: 556, n_steps: 139 }),
      recording({ id: 4, source: "scripted", player: null }),
      recording({ id: 3, verification: "failed", verification_note: "Frame 60 differs." }),
    ]);
    const first = within(await screen.findByRole("article", { name: "Recording 5" }));
    expect(first.getByText("2 of 2 targets, 1 stray")).toBeVisible();
    expect(first.getByText("139 steps, 9.3 s, hit by a bomb")).toBeVisible();
    expect(first.getByText("Ada")).toBeVisible();
    expect(first.getByText("verified")).toBeVisible();
    expect(first.getByRole("img", { name: /Hits per column, from the left: 1, 0/ })).toBeVisible();
    const second = within(screen.getByRole("article", { name: "Recording 4" }));
    expect(second.getByText("scripted")).toBeVisible();
    const third = within(screen.getByRole("article", { name: "Recording 3" }));
    expect(third.getByText("not verified: Frame 60 differs.")).toBeVisible();
  });

  it("does not offer to keep a game in which nothing was played", async () => {
    library([
      recording({ id: 5, state: "finished", end: null, n_steps: 0 }),
      recording({ id: 4, state: "unfinished", end: null, n_steps: 0 }),
    ]);
    for (const id of [5, 4]) {
      const card = within(await screen.findByRole("article", { name: `Recording ${id}` }));
      expect(card.getByText("Nothing was played, so there is nothing to keep.")).toBeVisible();
      expect(card.queryByRole("button", { name: /^Keep/ })).toBeNull();
      expect(card.getByRole("button", { name: `Discard Recording ${id}` })).toBeVisible();
    }
  });

  it("asks about games that nobody decided about, and says what can't be ranked and why", async () => {
    const { asked } = library(
      [
        recording({ id: 5, state: "finished", end: null, n_frames: 556, n_steps: 139 }),
        recording({ id: 4, state: "unfinished", end: null, n_frames: 556, n_steps: 139 }),
        recording({ id: 3, end: null, n_frames: 556, n_steps: 139 }),
        recording({ id: 2, verification: "failed" }),
      ],
      {
        "POST /api/recordings/5/keep": () => recording({ id: 5 }),
        "DELETE /api/recordings/5": () => undefined,
        "POST /api/recordings/4/keep": () => recording({ id: 4 }),
      },
    );
    expect(
      await screen.findByRole("heading", { name: /^1 recording.*and 3 that can’t be ranked yet$/ }),
    ).toBeVisible();
    await screen.findByRole("article", { name: "Recording 5" });
    const card = (id: number) => within(screen.getByRole("article", { name: `Recording ${id}` }));
    expect(card(5).getByText("139 steps, 9.3 s, ended early")).toBeVisible();
    expect(card(4).getByText("139 steps, 9.3 s, its page was left")).toBeVisible();
    expect(card(4).getByText(/^Unfinished: .* Keep it to rank it all the same\.$/)).toBeVisible();
    expect(card(2).getByText(/It can’t be ranked: a replay doesn’t reproduce it/)).toBeVisible();
    expect(card(3).queryByRole("button", { name: /Keep/ })).toBeNull();
    await userEvent.click(card(5).getByRole("button", { name: "Keep Recording 5" }));
    await userEvent.click(card(4).getByRole("button", { name: "Keep Recording 4" }));
    await userEvent.click(card(5).getByRole("button", { name: "Discard Recording 5" }));
    expect(await screen.findByText("Recording 5 discarded.")).toBeVisible();
    const did = asked.filter(({ method }) => method !== "GET");
    expect(did.map(({ method, path }) => `${method} ${path}`)).toEqual([
      "POST /api/recordings/5/keep",
      "POST /api/recordings/4/keep",
      "DELETE /api/recordings/5",
    ]);
  });

  it("says quietly which games were played with delay", async () => {
    const late = { presses: 40, p50_ms: 80, p95_ms: 180, frames_dropped: 120, is_bad: true };
    library([
      recording({ id: 5, latency: late }),
      recording({ id: 4, latency: { ...late, p95_ms: 48, frames_dropped: 0, is_bad: false } }),
      recording({ id: 3, latency: { ...late, p50_ms: null, p95_ms: null } }),
    ]);
    const notice = "played with delay";
    const first = within(await screen.findByRole("article", { name: "Recording 5" }));
    expect(first.getByText(notice)).toHaveAttribute(
      "title",
      "Played with delay: from key to screen 80 ms, 95% within 180 ms; 10% of the frames not drawn.",
    );
    const second = within(screen.getByRole("article", { name: "Recording 4" }));
    expect(second.queryByText(notice)).toBeNull();
    const third = within(screen.getByRole("article", { name: "Recording 3" }));
    expect(third.getByText(notice)).toHaveAttribute(
      "title",
      "Played with delay: 10% of the frames not drawn.",
    );
  });

  it("says which games were played in slow motion or frame by frame", async () => {
    library([
      recording({ id: 5, slowest_percent: 25, single_steps: 12 }),
      recording({ id: 4, slowest_percent: 100, single_steps: 0 }),
    ]);
    const first = within(await screen.findByRole("article", { name: "Recording 5" }));
    expect(first.getByText("slow motion, 25%; 12 frames one by one")).toBeVisible();
    const second = within(screen.getByRole("article", { name: "Recording 4" }));
    expect(second.queryByText(/slow motion|one by one/)).toBeNull();
  });

  it("works without a target", async () => {
    serve(libraryRoutes(() => [recording({ targets: null, strays: null })]));
    show(<RecordingsPage behaviour={behaviour({ target: null })} />);
    const card = within(await screen.findByRole("article", { name: "Recording 1" }));
    expect(card.getByText(/^survived all 300 steps/)).toBeVisible();
    expect(card.queryByText(/alien/i)).toBeNull();
    expect(card.queryByRole("img", { name: /Hits per column/ })).toBeNull();
    expect(screen.queryByRole("combobox", { name: "Aliens" })).toBeNull();
    const orders = within(screen.getByRole("combobox", { name: "Order" }));
    expect(orders.queryByRole("option", { name: "Most hits first" })).toBeNull();
  });

  it("marks as perfect at once, and takes it back if that is refused", async () => {
    library([recording({ targets: 2 })], {
      "PATCH /api/recordings/1": () => new Refusal(503, { detail: "The disk is full." }),
    });
    await userEvent.click(
      await screen.findByRole("button", { name: "Mark Recording 1 as perfect" }),
    );
    expect(await screen.findByText("The disk is full.")).toBeVisible();
    expect(screen.getByRole("button", { name: "Mark Recording 1 as perfect" })).toHaveAttribute(
      "aria-pressed",
      "false",
    );
  });

  it("asks before a game that missed or died is marked as perfect", async () => {
    const { asked } = library([recording({ strays: 2, end: "hit" })], {
      "PATCH /api/recordings/1": () => recording({ perfect: true }),
    });
    const star = await screen.findByRole("button", { name: "Mark Recording 1 as perfect" });
    const marked = () => asked.filter(({ method }) => method === "PATCH");
    await userEvent.click(star);
    expect(screen.getByRole("dialog")).toHaveTextContent(
      "it missed 1 target, it hit 2 strays, it was lost: hit by a bomb.",
    );
    await userEvent.click(screen.getByRole("button", { name: "Don’t mark" }));
    expect(marked()).toEqual([]);
    await userEvent.click(star);
    await userEvent.click(screen.getByRole("button", { name: "Mark all the same" }));
    await waitFor(() => expect(marked().map(({ body }) => body)).toEqual([{ perfect: true }]));
  });

  it("deletes, with a way back", async () => {
    const list = [recording({ id: 2 }), recording({ id: 1 })];
    const { asked } = library(list, {
      "DELETE /api/recordings/2": () => {
        list.shift();
        return undefined;
      },
      "POST /api/recordings/2/restore": () => {
        list.unshift(recording({ id: 2 }));
        return list[0];
      },
    });
    await userEvent.click(await screen.findByRole("button", { name: "Delete Recording 2" }));
    await waitFor(() => expect(screen.queryByRole("article", { name: "Recording 2" })).toBeNull());
    await userEvent.click(await screen.findByRole("button", { name: "Undo" }));
    expect(await screen.findByRole("article", { name: "Recording 2" })).toBeVisible();
    expect(asked.map(({ method }) => method)).toContain("DELETE");
  });

  it("keeps notes", async () => {
    const { asked } = library([recording()], {
      "PATCH /api/recordings/1": () => recording({ notes: "Too hasty." }),
    });
    await userEvent.click(await screen.findByRole("button", { name: "Write a note" }));
    await userEvent.type(screen.getByLabelText("Note"), "Too hasty.");
    await userEvent.click(screen.getByRole("button", { name: "Save note" }));
    await waitFor(() =>
      expect(asked.find(({ method }) => method === "PATCH")?.body).toEqual({ notes: "Too hasty." }),
    );
  });

  it("shows some of them only, and says so in the address", async () => {
    const { router } = library([
      recording({ id: 3, perfect: true, targets: 2 }),
      recording({ id: 2, targets: 2, strays: 2 }),
      recording({ id: 1 }),
    ]);
    const bar = within(await screen.findByRole("group", { name: "Selected recordings" }));
    expect(bar.getByRole("status")).toBeEmptyDOMElement();
    await userEvent.selectOptions(screen.getByLabelText("Show"), "Perfect ones");
    expect(names()).toEqual(["Recording 3"]);
    expect(bar.getByText("1 of 3 shown")).toBeVisible();
    await userEvent.selectOptions(screen.getByLabelText("Show"), "All");
    await userEvent.selectOptions(screen.getByLabelText("Targets"), "2 or more");
    expect(names()).toEqual(["Recording 3", "Recording 2"]);
    await userEvent.selectOptions(screen.getByLabelText("Order"), "Oldest first");
    expect(names()).toEqual(["Recording 2", "Recording 3"]);
    await userEvent.selectOptions(screen.getByLabelText("Strays"), "None");
    expect(names()).toEqual(["Recording 3"]);
    expect(router.state.location.search).toBe("?hits=2&strays=0&order=oldest");
    await userEvent.click(screen.getByRole("button", { name: "Clear the filters" }));
    expect(names()).toHaveLength(3);
  });

  it("shows what an address asks for", async () => {
    library([recording({ id: 2, player: "Bo" }), recording({ id: 1 })], {}, "/?player=Bo");
    await screen.findByRole("article", { name: "Recording 2" });
    expect(names()).toEqual(["Recording 2"]);
    expect(screen.getByLabelText("Player")).toHaveDisplayValue("Bo");
  });

  it("does the same to all that are selected, and takes a deletion back", async () => {
    const list = [4, 3, 2, 1].map((id) => recording({ id }));
    const gone: Recording[] = [];
    const { asked } = library(list, {
      "POST /api/behaviours/1/recordings/change": ({ body }) => {
        const { change, recording_ids: ids } = body as {
          change: string;
          recording_ids: number[];
        };
        if (change === "delete") {
          gone.push(...list.splice(0, ids.length));
        } else {
          list.unshift(...gone.splice(0));
        }
        return undefined;
      },
    });
    await userEvent.click(await screen.findByLabelText("Select Recording 4"));
    const user = userEvent.setup();
    await user.keyboard("{Shift>}");
    await user.click(screen.getByLabelText("Select Recording 2"));
    await user.keyboard("{/Shift}");
    const bar = within(screen.getByRole("group", { name: "Selected recordings" }));
    expect(bar.getByText("3 recordings selected")).toBeVisible();
    expect(bar.getByRole("link", { name: "Export selected" })).toHaveAttribute(
      "href",
      "/api/behaviours/1/recordings/export?recording=4&recording=3&recording=2",
    );
    await userEvent.click(bar.getByRole("button", { name: "Delete" }));
    await waitFor(() => expect(names()).toEqual(["Recording 1"]));
    await userEvent.click(await screen.findByRole("button", { name: "Undo" }));
    await waitFor(() => expect(names()).toHaveLength(4));
    expect(asked.filter(({ method }) => method === "POST").map(({ body }) => body)).toEqual([
      { recording_ids: [4, 3, 2], change: "delete" },
      { recording_ids: [4, 3, 2], change: "restore" },
    ]);
  });

  it("marks all shown ones, and takes the marks off when all have one", async () => {
    const list = [2, 1].map((id) => recording({ id }));
    const { asked } = library(list, {
      "POST /api/behaviours/1/recordings/change": () => {
        list.forEach((one, index) => (list[index] = { ...one, perfect: true }));
        return list;
      },
    });
    await userEvent.click(await screen.findByRole("button", { name: "Select all shown" }));
    const bar = within(screen.getByRole("group", { name: "Selected recordings" }));
    await userEvent.click(bar.getByRole("button", { name: "Mark as perfect" }));
    expect(screen.getByRole("dialog")).toHaveTextContent("2 of 2 games aren’t perfect");
    await userEvent.click(screen.getByRole("button", { name: "Mark all the same" }));
    await userEvent.click(await bar.findByRole("button", { name: "Remove the perfect marks" }));
    await waitFor(() =>
      expect(
        asked
          .filter(({ method }) => method === "POST")
          .map(({ body }) => (body as { change: string }).change),
      ).toEqual(["mark_perfect", "unmark_perfect"]),
    );
  });

  it("changes and exports as many at once as are selected", async () => {
    const many = Array.from({ length: 501 }, (_, index) => recording({ id: 501 - index }));
    const ids = many.map(({ id }) => id);
    const { asked } = library(many, {
      "POST /api/behaviours/1/recordings/change": () => undefined,
      "POST /api/behaviours/1/recordings/export": () => new Response("{}\n"),
    });
    vi.stubGlobal(
      "URL",
      Object.assign(URL, { createObjectURL: () => "blob:", revokeObjectURL: vi.fn() }),
    );
    await userEvent.click(await screen.findByRole("button", { name: "Select all shown" }));
    expect(screen.getByText("501 recordings selected")).toBeVisible();
    await userEvent.click(screen.getByRole("button", { name: "Export selected" }));
    await userEvent.click(screen.getByRole("button", { name: "Delete" }));
    await waitFor(() =>
      expect(asked.filter(({ method }) => method === "POST").map(({ body }) => body)).toEqual([
        { recording_ids: ids },
        { recording_ids: ids, change: "delete" },
      ]),
    );
  });

  it("has only what is in sight in the document, however many there are", async () => {
    const many = Array.from({ length: 20_000 }, (_, index) => recording({ id: 20_000 - index }));
    const { asked } = library(many);
    const first = await screen.findByRole("article", { name: "Recording 20000" });
    expect(first.closest("[role=listitem]")).toHaveAttribute("aria-setsize", "20000");
    expect(first.closest("[role=listitem]")).toHaveAttribute("aria-posinset", "1");
    expect(names().length).toBeLessThan(20);
    expect(document.querySelectorAll("*").length).toBeLessThan(1500);
    const fetched = asked.flatMap(({ query }) => query.getAll("recording"));
    expect(fetched).toHaveLength(names().length);
    await userEvent.type(screen.getByLabelText("Number"), "12345");
    await waitFor(() => expect(names()).toEqual(["Recording 12345"]));
  });

  it("shows the newest of many until the others are there", async () => {
    const many = Array.from({ length: 2500 }, (_, index) =>
      recording({ id: 2500 - index, perfect: index === 2400 }),
    );
    const { promise: others, resolve } = deferred();
    const { asked } = library(many, {
      "GET /api/behaviours/1/library": async ({ query }) => {
        if (query.has("before")) await others;
        return partOf(many, query);
      },
    });
    const first = await screen.findByRole("article", { name: "Recording 2500" });
    expect(screen.getByRole("heading", { name: "2,500 recordings" })).toBeVisible();
    expect(first.closest("[role=listitem]")).toHaveAttribute("aria-setsize", "200");
    expect(screen.getByText("Loading the others…")).toBeVisible();
    expect(screen.queryByRole("button", { name: "Select all shown" })).toBeNull();
    await userEvent.click(screen.getByLabelText("Select Recording 2500"));
    // One that may be among the others.
    await userEvent.selectOptions(screen.getByLabelText("Show"), "Perfect ones");
    expect(names()).toEqual([]);
    expect(screen.queryByText("No recording matches the filters.")).toBeNull();
    resolve();
    await waitFor(() => expect(names()).toEqual(["Recording 100"]));
    await userEvent.selectOptions(screen.getByLabelText("Show"), "All");
    await userEvent.click(screen.getByRole("button", { name: "Select all shown" }));
    expect(screen.getByText("2,500 recordings selected")).toBeVisible();
    const parts = asked.filter(({ path }) => path.endsWith("/library"));
    expect(parts.map(({ query }) => query.toString())).toEqual([
      "limit=200",
      "before=2301&limit=2000",
      "before=301&limit=2000",
      "since=1",
    ]);
  });

  it("says what failed where the others can't be fetched", async () => {
    const many = Array.from({ length: 201 }, (_, index) => recording({ id: 201 - index }));
    let isDown = true;
    library(many, {
      "GET /api/behaviours/1/library": ({ query }) =>
        isDown && query.has("before")
          ? new Refusal(503, { detail: "The server is busy." })
          : partOf(many, query),
    });
    expect(await screen.findByText("The server is busy.")).toBeVisible();
    isDown = false;
    await userEvent.click(screen.getByRole("button", { name: "Try again" }));
    await screen.findByRole("button", { name: "Select all shown" });
    expect(screen.getByRole("heading", { name: "201 recordings" })).toBeVisible();
  });

  it("fetches only what somebody else changed", async () => {
    const list = [3, 2, 1].map((id) => recording({ id }));
    let cursor = 7;
    const { asked, client } = library(list, {
      "GET /api/behaviours/1/library": ({ query }) =>
        query.has("since")
          ? libraryOf([recording({ id: 2, perfect: true })], { cursor, whole: false, removed: [3] })
          : libraryOf(list, { cursor }),
    });
    await screen.findByLabelText("Select Recording 3");
    const before = asked.length;
    cursor = 9;
    list.splice(0, 2, recording({ id: 2, perfect: true }));
    const invalidator = new Invalidator(client);
    invalidator.add({ topic: "recording", key: "2" });
    const star = { name: "Recording 2 is perfect. Remove the mark" };
    expect(await screen.findByRole("button", star)).toHaveAttribute("aria-pressed", "true");
    await waitFor(() => expect(names()).toEqual(["Recording 2", "Recording 1"]));
    const since = asked.slice(before);
    expect(since.map(({ path, query }) => `${path}?${query.toString()}`).sort()).toEqual([
      "/api/behaviours/1/library/recordings?recording=2",
      "/api/behaviours/1/library?since=7",
    ]);
  });

  it("lists the deleted ones to restore them, also when nothing else is left", async () => {
    const deleted = recording({ id: 4, deleted: true });
    const asked = serve({
      ...libraryRoutes(
        () => [],
        () => [deleted],
      ),
      "POST /api/recordings/4/restore": () => deleted,
    });
    show(<RecordingsPage behaviour={behaviour()} />);
    await userEvent.click(await screen.findByRole("link", { name: "Deleted recordings" }));
    await userEvent.click(await screen.findByRole("button", { name: "Restore Recording 4" }));
    await waitFor(() => expect(asked.map(({ method }) => method)).toContain("POST"));
    expect(screen.queryByRole("button", { name: "Delete Recording 4" })).toBeNull();
  });
});

function names(): (string | null)[] {
  return screen.queryAllByRole("article").map((one) => one.getAttribute("aria-label"));
}

describe("importing", () => {
  const IMPORT = "POST /api/behaviours/1/recordings/import";

  async function send(answer: () => unknown) {
    const { asked } = library([], { [IMPORT]: answer });
    await userEvent.click(await screen.findByRole("button", { name: "Import recordings" }));
    const dialog = within(screen.getByRole("dialog", { name: "Import recordings" }));
    const file = new File(['{"format":"tril-recording"}\n'], "games.jsonl");
    await userEvent.upload(dialog.getByLabelText("File of recordings"), file);
    await userEvent.click(dialog.getByLabelText("The order is a ranking, best first"));
    await userEvent.click(dialog.getByRole("button", { name: "Import" }));
    return { dialog, asked };
  }

  it("lists each refusal with its line and reason", async () => {
    const { dialog, asked } = await send(() => ({
      imported: [7],
      already_there: [9],
      notices: [{ line: 1, reason: "Cut after the hit." }],
      refusals: [{ line: 3, reason: "Another ROM." }],
      n_notices: 1,
      n_refused: 10_000,
    }));
    expect(await dialog.findByText("1 recording imported")).toBeVisible();
    const rows = dialog.getAllByRole("row").map((row) => row.textContent);
    expect(rows).toEqual([
      "LineWhat happened",
      "1Imported, but: Cut after the hit.",
      "3Refused: Another ROM.",
    ]);
    expect(dialog.getByText("And 9,999 more lines.")).toBeVisible();
    expect(dialog.getByRole("status")).toHaveTextContent("10000 refused");
    const query = asked.find(({ method }) => method === "POST")?.query;
    expect(dialog.getByRole("status")).toHaveTextContent("1 already there and not imported again");
    expect(query?.get("rank")).toBe("true");
    expect(query?.get("perfect")).toBe("false");
  });

  it("says why a whole file is refused", async () => {
    const { dialog } = await send(() => new Refusal(413, null));
    expect(await dialog.findByRole("alert")).toHaveTextContent("The file is too large.");
  });
});
