import { screen, waitFor, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { describe, expect, it, vi } from "vitest";

import type { Ranking } from "@/api/types";
import { RankPage } from "@/features/ranking/RankPage";

import { behaviour, ranking, recording } from "../../../support/data";
import { framesFile } from "../../../support/frames";
import { libraryRoutes } from "../../../support/library";
import { show } from "../../../support/page";
import { type Asked, Refusal, serve } from "../../../support/server";

const IDS = [1, 2, 3, 4, 5, 6];
const N_FRAMES = 8;

/** A fake server with six recordings, of which some are ranked; 5 is borrowed. */
function rankingServer(begin: Partial<Ranking>) {
  let standing = ranking(begin);
  const history: number[][][] = [];
  const put = (tiers: number[][]) => {
    standing = {
      ...standing,
      revision: standing.revision + 1,
      tiers,
      can_undo: history.length > 0,
    };
    return standing;
  };
  const all = IDS.map((id) => recording({ id, borrowed: id === 5 }));
  const asked = serve({
    "GET /api/behaviours/1/ranking": () => standing,
    ...libraryRoutes(() => all),
    "GET /api/behaviours/1/ranking/opinion": () => ({
      revision: standing.revision,
      games: [],
      wanted: null,
    }),
    "PUT /api/behaviours/1/ranking": ({ body }: Asked) => {
      const { base_revision: base, tiers } = body as { base_revision: number; tiers: number[][] };
      if (base !== standing.revision)
        return new Refusal(409, { detail: "Saved elsewhere.", current: standing, yours: tiers });
      history.push(standing.tiers);
      return put(tiers);
    },
    "POST /api/behaviours/1/ranking/undo": () => put(history.pop() ?? []),
    ...Object.fromEntries(
      IDS.map((id) => [`GET /api/recordings/${id}/frames`, () => framesFile(N_FRAMES)]),
    ),
  });
  return {
    asked,
    elsewhere: put,
    now: () => standing,
    saves: () => asked.filter(({ method }) => method === "PUT").length,
  };
}

async function open(begin: Partial<Ranking>, path = "/") {
  const server = rankingServer(begin);
  const page = show(<RankPage behaviour={behaviour({ n_recordings: 6 })} />, path);
  await screen.findByRole("heading", { name: "Best to worst" });
  await waitFor(() => expect(document.querySelector("[aria-busy=true]")).toBeNull());
  return { ...server, ...page };
}

const tray = () => within(screen.getByRole("region", { name: /^Unranked/ }));
const start = () => userEvent.click(tray().getByRole("button", { name: "Place by comparing" }));
const dialog = () => within(screen.getByRole("dialog"));
const press = (name: string) => userEvent.click(dialog().getByRole("button", { name }));

/** The recording that is to be placed, and the one it is compared with. */
function compared(): string[] {
  return dialog()
    .getAllByRole("heading", { level: 3 })
    .map((heading) => heading.textContent.replace(/^Recording (\d+).*/, "$1"));
}

describe("placing by comparing", () => {
  it("places one recording after another by keyboard, each in one revision", async () => {
    const server = await open({ tiers: [[1], [2], [3]] });
    tray().getByRole("button", { name: "Place by comparing" }).focus();
    await userEvent.keyboard("{Enter}");
    expect(screen.getByRole("dialog", { name: "Which is better?" })).toBeVisible();
    expect(dialog().getByRole("group", { name: "Comparison" })).toHaveFocus();
    expect(dialog().getByText("Game 1 of 3, about 2 more looks")).toBeVisible();
    expect(compared()).toEqual(["6", "2"]);
    expect(dialog().getByText("tier 2 of 3")).toBeVisible();

    await userEvent.keyboard("{ArrowLeft}");
    expect(compared()).toEqual(["6", "1"]);
    expect(dialog().getByText("Game 1 of 3, about 1 more look")).toBeVisible();
    expect(server.saves()).toBe(0);
    await userEvent.keyboard("{ArrowRight}");
    await waitFor(() => expect(server.now().tiers).toEqual([[1], [6], [2], [3]]));
    expect(dialog().getByText("Game 2 of 3, about 3 more looks")).toBeVisible();
    expect(dialog().getByText(/^Recording 6: tier 2 of 4, alone\. Which is better/)).toBeVisible();

    await userEvent.keyboard("=");
    await waitFor(() => expect(server.now().tiers).toEqual([[1], [6], [2, 5], [3]]));
    await userEvent.keyboard("w");
    await waitFor(() => expect(server.now().tiers).toEqual([[1], [6], [2, 5], [3], [4]]));
    expect(server.now().revision).toBe(4);
    expect(dialog().getByText(/^3 recordings have their place\./)).toBeVisible();
    expect(dialog().getByRole("button", { name: "Back to the ranking" })).toHaveFocus();
    await userEvent.keyboard("{Enter}");
    expect(screen.queryByRole("dialog")).toBeNull();
    await waitFor(() =>
      expect(screen.getByRole("heading", { name: "Unranked (0)" })).toHaveFocus(),
    );
  });

  it("compares with a person's own recording rather than a borrowed one", async () => {
    await open({ tiers: [[5, 3], [1]] });
    await start();
    await press("Left is better");
    expect(compared()).toEqual(["6", "3"]);
  });

  it("takes only what is selected", async () => {
    const server = await open({ tiers: [[1], [2]] });
    for (const id of [1, 6, 4])
      await userEvent.click(screen.getByRole("checkbox", { name: `Select Recording ${id}` }));
    const bar = within(screen.getByRole("group", { name: "Selected recordings" }));
    await userEvent.click(bar.getByRole("button", { name: "Place by comparing" }));
    expect(dialog().getByText(/^Game 1 of 2/)).toBeVisible();
    expect(compared()[0]).toBe("6");
    await press("All 2 left below the worst");
    await waitFor(() => expect(server.now().tiers).toEqual([[1], [2], [6, 4]]));
    await press("Back to the ranking");
    expect(screen.queryByRole("group", { name: "Selected recordings" })).toBeNull();
  });

  it("leaves what is skipped unranked", async () => {
    const server = await open({ tiers: [[1], [2], [3]] });
    await start();
    await press("Skip");
    expect(dialog().getByText(/^Recording 6 stays unranked\./)).toBeInTheDocument();
    expect(compared()[0]).toBe("5");
    await userEvent.keyboard("sw");
    await waitFor(() => expect(server.now().tiers).toEqual([[1], [2], [3], [4]]));
    expect(dialog().getByText(/2 were skipped and stay unranked\./)).toBeVisible();
    await press("Back to the ranking");
    expect(tray().getByRole("button", { name: "Place by comparing" })).toHaveFocus();
  });

  it("is offered only if there is something to place and something to compare with", async () => {
    await open({ tiers: [[1, 2]] });
    expect(screen.queryByRole("button", { name: "Place by comparing" })).toBeNull();
    await userEvent.click(screen.getByRole("button", { name: "Own tier: Recording 2" }));
    expect(screen.getByRole("button", { name: "Place by comparing" })).toBeVisible();
  });

  it("begins at once where the address asks for it, and the address forgets it", async () => {
    const { router } = await open({ tiers: [[1], [2]] }, "/?compare");
    expect(dialog().getByText(/^Game 1 of 4/)).toBeVisible();
    await press("Close");
    expect(screen.queryByRole("dialog")).toBeNull();
    expect(router.state.location.search).toBe("");
  });
});

describe("undo while comparing", () => {
  it("takes answers back one by one, across recordings, and with them their places", async () => {
    const server = await open({ tiers: [[1], [2], [3]] });
    await start();
    expect(dialog().getByRole("button", { name: "Undo" })).toHaveAttribute("aria-disabled", "true");
    await userEvent.keyboard("{ArrowLeft}{ArrowLeft}s");
    await waitFor(() => expect(server.now().tiers).toEqual([[6], [1], [2], [3]]));
    expect(compared()[0]).toBe("4");
    await userEvent.keyboard("u");
    expect(compared()[0]).toBe("5");
    await press("Undo");
    await waitFor(() => expect(server.now().tiers).toEqual([[1], [2], [3]]));
    await waitFor(() => expect(compared()).toEqual(["6", "1"]));
    expect(server.asked.filter(({ path }) => path.endsWith("/undo"))).toHaveLength(1);
    await userEvent.keyboard("{Control>}z{/Control}");
    expect(compared()).toEqual(["6", "2"]);
    expect(server.asked.filter(({ path }) => path.endsWith("/undo"))).toHaveLength(1);
  });

  it("is there at the end, too", async () => {
    const server = await open({ tiers: [[1], [2], [3], [4], [5]] });
    await start();
    await press("Equally good");
    await press("Undo the last answer");
    await waitFor(() => expect(server.now().tiers).toEqual([[1], [2], [3], [4], [5]]));
    await waitFor(() => expect(compared()).toEqual(["6", "3"]));
    await waitFor(() => expect(dialog().getByRole("group", { name: "Comparison" })).toHaveFocus());
  });

  it("leaves alone what was changed elsewhere in the meantime", async () => {
    const server = await open({ tiers: [[1], [2], [3]] });
    await start();
    await press("Equally good");
    await waitFor(() => expect(server.now().tiers).toEqual([[1], [2, 6], [3]]));
    server.elsewhere([[3], [2, 6], [1]]);
    await server.client.invalidateQueries({ queryKey: ["ranking"] });
    await press("Undo");
    await waitFor(() => expect(server.now().tiers).toEqual([[3], [2], [1]]));
    expect(server.asked.filter(({ path }) => path.endsWith("/undo"))).toHaveLength(0);
  });
});

describe("what may go wrong while comparing", () => {
  it("is said where a game can't be shown, which can still be judged", async () => {
    const server = await open({ tiers: [[1], [2], [3]] });
    const online = globalThis.fetch;
    vi.stubGlobal("fetch", (input: Request | string, init?: RequestInit) =>
      (typeof input === "string" ? input : input.url).includes("/recordings/2/frames")
        ? Promise.resolve(new Response('{"detail": "Too much to do."}', { status: 503 }))
        : online(input, init),
    );
    await start();
    const failed = within(await dialog().findByRole("alert"));
    expect(failed.getByText("Recording 2 could not be loaded")).toBeVisible();
    expect(dialog().getByRole("img", { name: "Game screen of Recording 6" })).toBeVisible();
    vi.stubGlobal("fetch", online);
    await userEvent.click(failed.getByRole("button", { name: "Try again" }));
    expect(await dialog().findByRole("img", { name: "Game screen of Recording 2" })).toBeVisible();
    await press("Equally good");
    await waitFor(() => expect(server.now().tiers).toEqual([[1], [2, 6], [3]]));
  });

  it("is said where the order can't be saved, and it goes on", async () => {
    const server = await open({ tiers: [[1], [2], [3]] });
    await start();
    const online = globalThis.fetch;
    vi.stubGlobal("fetch", () => Promise.reject(new TypeError("offline")));
    await press("Below the worst");
    expect(await dialog().findByText(/The order could not be saved/)).toBeVisible();
    vi.stubGlobal("fetch", online);
    await press("Below the worst");
    await waitFor(() => expect(server.now().tiers).toEqual([[1], [2], [3], [6], [5]]));
    expect(dialog().queryByText(/The order could not be saved/)).toBeNull();
  });

  it("is settled in a dialog above if the order was changed elsewhere", async () => {
    const server = await open({ tiers: [[1], [2], [3]] });
    await start();
    server.elsewhere([[3], [2], [1]]);
    await press("Below the worst");
    const conflict = within(await screen.findByRole("dialog", { name: /changed elsewhere/ }));
    await userEvent.keyboard("w");
    await userEvent.click(conflict.getByRole("button", { name: "Keep theirs" }));
    expect(dialog().getByText(/^Game 1 of 3/)).toBeVisible();
    expect(compared()[0]).toBe("6");
    await press("Below the worst");
    await waitFor(() => expect(server.now().tiers).toEqual([[3], [2], [1], [6]]));
  });
});

describe("both games", () => {
  const position = () => dialog().findByRole("slider", { name: "Position in the recording" });

  it("play in step at once, and answers are not taken from a focused control's keys", async () => {
    const server = await open({ tiers: [[1], [2], [3]] });
    await start();
    const slider = await position();
    expect(slider).toHaveAttribute("max", String(N_FRAMES));
    slider.focus();
    await userEvent.keyboard("{ArrowLeft}");
    expect(compared()).toEqual(["6", "2"]);
    dialog().getByRole("combobox", { name: "Speed" }).focus();
    await userEvent.keyboard("w");
    expect(server.saves()).toBe(0);
  });

  it("show how they end and wait where less motion is wanted", async () => {
    const matches = globalThis.matchMedia;
    vi.stubGlobal("matchMedia", (query: string) =>
      Object.assign(matches(query), { matches: query.includes("reduced-motion") }),
    );
    await open({ tiers: [[1], [2], [3]] });
    await start();
    expect(await position()).toHaveValue(String(N_FRAMES));
    expect(dialog().getByRole("button", { name: "Play" })).toBeVisible();
  });
});
