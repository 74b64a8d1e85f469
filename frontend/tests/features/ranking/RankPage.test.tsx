import { act, cleanup, screen, waitFor, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { describe, expect, it, vi } from "vitest";

import type { GameOpinion, Ranking, RankingOpinion, Recording } from "@/api/types";
import { readDraft, writeDraft } from "@/lib/browser/drafts";
import { RankPage } from "@/features/ranking/RankPage";

import { behaviour, ranking, recording } from "../../support/data";
import { libraryRoutes, partOf } from "../../support/library";
import { show } from "../../support/page";
import { type Asked, deferred, Refusal, serve } from "../../support/server";

/** Column 2 is wanted, but it is not sure of its highest alien. */
const WANTED = {
  labels: Array.from({ length: 36 }, (_, index) =>
    index % 6 !== 1 ? -0.9 : index === 31 ? 0.2 : 0.9,
  ),
  in_order: Array.from({ length: 36 }, () => 0),
};

/** A fake server with one ranking and its revisions. */
function rankingServer(
  begin: Partial<Ranking>,
  opinion: () => Partial<RankingOpinion> = () => ({}),
  more: readonly Recording[] = [],
) {
  const all = [1, 2, 3, 4].map((id) =>
    recording({
      id,
      perfect: id === 1,
      parent: id === 4 ? { recording_id: 3, number: 3, frame: 300 } : null,
    }),
  );
  all.push(...more);
  let standing = ranking(begin);
  const history = [standing];
  const put = (tiers: number[][], more: Partial<Ranking> = {}) => {
    standing = ranking({
      ...more,
      revision: standing.revision + 1,
      tiers,
      can_undo: true,
    });
    history.push(standing);
    return standing;
  };
  const varied = [
    recording({
      id: 11,
      behaviour_id: 2,
      behaviour_name: "Column 2",
      borrowed: true,
      targets: 0,
    }),
    recording({ id: 12, source: "varied", player: null, targets: 0 }),
    recording({ id: 13, source: "varied", player: null, targets: 6 }),
  ];
  const asked = serve({
    ...libraryRoutes(() => all),
    "POST /api/behaviours/1/borrowed": () => {
      all.push(...varied);
      return varied;
    },
    "DELETE /api/behaviours/1/borrowed/11": () => {
      all.splice(
        all.findIndex(({ id }) => id === 11),
        1,
      );
      return undefined;
    },
    "GET /api/behaviours/1/ranking": () => standing,
    "GET /api/behaviours/1/ranking/opinion": () => ({
      revision: standing.revision,
      games: [],
      wanted: WANTED,
      ...opinion(),
    }),
    "PUT /api/behaviours/1/ranking": ({ body }: Asked) => {
      const { base_revision: base, tiers } = body as { base_revision: number; tiers: number[][] };
      if (base === standing.revision) return put(tiers);
      return new Refusal(409, { detail: "Saved elsewhere.", current: standing, yours: tiers });
    },
    "POST /api/behaviours/1/ranking/undo": () =>
      put(history.at(-2)?.tiers ?? [], { can_redo: true }),
    "POST /api/behaviours/1/ranking/redo": () => put([[2], [1]]),
  });
  return { asked, elsewhere: put, now: () => standing };
}

async function open(
  begin: Partial<Ranking>,
  opinion?: () => Partial<RankingOpinion>,
  more: readonly Recording[] = [],
  path = "/",
) {
  const server = rankingServer(begin, opinion, more);
  const page = show(<RankPage behaviour={behaviour({ n_recordings: 4 })} />, path);
  await screen.findByRole("heading", { name: "Best to worst" });
  await waitFor(() => expect(document.querySelector("[aria-busy=true]")).toBeNull());
  return { ...server, ...page };
}

/** The board as a list of tiers of recording numbers. */
function board(): string[][] {
  const tiers = screen
    .queryAllByRole("listitem")
    .filter((item) => item.getAttribute("aria-label")?.startsWith("Tier"));
  return tiers.map((tier) =>
    within(tier)
      .getAllByRole("heading")
      .map((heading) => heading.textContent.replace("Recording ", "")),
  );
}

const press = (name: string) => userEvent.click(screen.getByRole("button", { name }));

describe("a library of many recordings", () => {
  const many = Array.from({ length: 300 }, (_, index) =>
    recording({ id: 300 - index, perfect: index >= 298, ranked: index >= 298 }),
  );

  function openMany(path: string) {
    const { promise, resolve } = deferred();
    serve({
      ...libraryRoutes(() => many),
      "GET /api/behaviours/1/library": async ({ query }) => {
        if (query.has("before")) await promise;
        return partOf(many, query);
      },
      "GET /api/behaviours/1/ranking": () => ranking({ tiers: [[1], [2]] }),
      "GET /api/behaviours/1/ranking/opinion": () => ({ revision: 0, games: [], wanted: null }),
    });
    const shown = behaviour({ n_recordings: 300, n_perfect: 2, n_ranked: 2 });
    show(<RankPage behaviour={shown} />, path);
    return resolve;
  }

  it("shows the order and the newest until the others are there", async () => {
    const resolve = openMany("/");
    const tray = await screen.findByRole("region", { name: "Unranked, 298 recordings" });
    expect(await within(tray).findByLabelText("Select Recording 300")).toBeVisible();
    await waitFor(() => expect(board()).toEqual([["1"], ["2"]]));
    await unfoldNeeds();
    expect(screen.getByText(/^2 games have a star/)).toBeVisible();
    expect(screen.queryByRole("button", { name: "Place by comparing" })).toBeNull();
    resolve();
    await screen.findByRole("button", { name: "Place by comparing" });
    expect(screen.getByRole("region", { name: "Unranked, 298 recordings" })).toBeVisible();
    expect(board()).toEqual([["1"], ["2"]]);
    expect(screen.getByText(/^2 games have a star/)).toBeVisible();
  });

  it("waits for all of them before it compares", async () => {
    const resolve = openMany("/?compare");
    await waitFor(() => expect(screen.getByText("Loading the ranking…")).toBeInTheDocument());
    resolve();
    expect(await screen.findByRole("dialog")).toBeVisible();
  });
});

describe("a run that is to be continued", () => {
  const further = "continue=abcdef00-0000-4000-8000-000000000000&steps=200000";

  it("is led on with to the training form, and named", async () => {
    await open({ tiers: [[1], [2]] }, undefined, [], `/?${further}`);
    expect(screen.getByText("The next run continues Run abcdef.")).toBeVisible();
    expect(screen.getByRole("link", { name: "Continue to Train" })).toHaveAttribute(
      "href",
      `/behaviours/1/train?${further}`,
    );
  });

  it("stays when placing by comparing ends", async () => {
    const { router } = await open({ tiers: [[1], [2]] }, undefined, [], `/?${further}&compare`);
    await userEvent.click(screen.getByRole("button", { name: "Close" }));
    await waitFor(() => expect(router.state.location.search).toBe(`?${further}`));
  });
});

describe("unranked recordings below all tiers", () => {
  const narrow = () => {
    const matches = globalThis.matchMedia;
    vi.stubGlobal("matchMedia", (query: string) =>
      Object.assign(matches(query), { matches: query.includes("max-width") }),
    );
  };

  it("are led to from above the tiers", async () => {
    narrow();
    await open({ tiers: [[1], [2]] });
    await press("2 games not ranked yet");
    expect(screen.getByRole("heading", { name: "Unranked (2)" })).toHaveFocus();
  });

  it("need no lead while there are none, or beside the tiers", async () => {
    await open({ tiers: [[1], [2]] });
    expect(screen.queryByRole("button", { name: /not ranked yet/ })).toBeNull();
    narrow();
    await press("Rank as worst: Recording 3");
    await press("Rank as worst: Recording 4");
    expect(screen.queryByRole("button", { name: /not ranked yet/ })).toBeNull();
  });
});

describe("a card that leaves the screen and comes back", () => {
  it("stays where both are reported at once", async () => {
    const observers: { element: Element; report: IntersectionObserverCallback }[] = [];
    vi.stubGlobal(
      "IntersectionObserver",
      class {
        private readonly report: IntersectionObserverCallback;
        constructor(report: IntersectionObserverCallback) {
          this.report = report;
        }
        observe(element: Element) {
          observers.push({ element, report: this.report });
        }
        disconnect() {
          /* nothing else is reported */
        }
      },
    );
    await open({ tiers: [[1], [2]] });
    expect(screen.queryByRole("heading", { name: "Recording 1" })).toBeNull();
    for (const { element, report } of observers) {
      const entries = [false, true].map((isIntersecting) => ({
        isIntersecting,
        boundingClientRect: element.getBoundingClientRect(),
      }));
      act(() => report(entries as IntersectionObserverEntry[], {} as IntersectionObserver));
    }
    await waitFor(() => expect(board()).toEqual([["1"], ["2"]]));
  });
});

describe("a game that was rewound", () => {
  it("is offered as a pair with its other branch, and ranked next to it", async () => {
    const server = await open({ tiers: [[1], [3], [2]] });
    const pair = within(screen.getByRole("region", { name: "Pairs to compare" }));
    expect(pair.getByText("Recording 4 branches off Recording 3 at 5.0 s.")).toBeVisible();
    await userEvent.click(pair.getByRole("button", { name: "Recording 4 is better" }));
    expect(board()).toEqual([["1"], ["4"], ["3"], ["2"]]);
    expect(screen.queryByRole("region", { name: "Pairs to compare" })).toBeNull();
    await waitFor(() => expect(server.now().tiers).toEqual([[1], [4], [3], [2]]));
  });
});

describe("an empty board", () => {
  it("asks for no comparison of two games before there is an order", async () => {
    await open({});
    expect(screen.queryByRole("region", { name: "Pairs to compare" })).toBeNull();
    await press("Rank as worst: Recording 1");
    expect(screen.getByRole("region", { name: "Pairs to compare" })).toBeVisible();
  });
});

describe("ranking by buttons", () => {
  it("takes recordings from the tray, moves, ties and unties them, and saves each change", async () => {
    const server = await open({});
    expect(board()).toEqual([]);
    await press("Rank as worst: Recording 1");
    await press("Rank as worst: Recording 2");
    await press("Rank as best: Recording 3");
    expect(board()).toEqual([["3"], ["1"], ["2"]]);
    await press("Down: Recording 3");
    expect(board()).toEqual([["1"], ["3"], ["2"]]);
    await press("Tie with the tier above: Recording 2");
    expect(board()).toEqual([["1"], ["3", "2"]]);
    await press("Own tier: Recording 3");
    expect(board()).toEqual([["1"], ["2"], ["3"]]);
    await press("Back to unranked: Recording 2");
    expect(board()).toEqual([["1"], ["3"]]);
    await waitFor(() => expect(server.now().tiers).toEqual([[1], [3]]));
    expect(screen.getByText("Saved")).toBeVisible();
  });

  it("saves by itself once the network is back", async () => {
    const server = await open({ tiers: [[1], [3], [2]] });
    const online = globalThis.fetch;
    vi.stubGlobal("fetch", () => Promise.reject(new TypeError("offline")));
    await press("Rank as worst: Recording 4");
    expect(await screen.findByText("Not saved")).toBeVisible();
    expect(screen.getByRole("alert")).toHaveTextContent("tries again by itself");
    vi.stubGlobal("fetch", online);
    window.dispatchEvent(new Event("online"));
    expect(await screen.findByText("Saved")).toBeVisible();
    expect(server.now().tiers).toEqual([[1], [3], [2], [4]]);
  });

  it("says where a recording went", async () => {
    await open({ tiers: [[1], [2], [3]] });
    await press("Up: Recording 3");
    expect(screen.getByText("Recording 3: tier 2 of 3, alone.")).toBeInTheDocument();
    await press("Tie with the tier above: Recording 3");
    expect(screen.getByText("Recording 3: tier 1 of 2, tied with 1.")).toBeInTheDocument();
  });

  it("keeps the focus on the button that was pressed", async () => {
    await open({ tiers: [[1], [2], [3]] });
    await press("Tie with the tier above: Recording 3");
    expect(
      screen.getByRole("button", { name: "Tie with the tier above: Recording 3" }),
    ).toHaveFocus();
  });

  it("does nothing where there is nothing to do", async () => {
    const server = await open({ tiers: [[1], [2]] });
    const up = screen.getByRole("button", { name: "Up: Recording 1" });
    expect(up).toHaveAttribute("aria-disabled", "true");
    await userEvent.click(up);
    expect(server.asked.filter(({ method }) => method === "PUT")).toEqual([]);
  });
});

describe("an order that could not be saved", () => {
  const refusal = () => new Response('{"detail": "Busy."}', { status: 503 });

  async function openRefused() {
    const server = await open({ tiers: [[1], [2], [3]] });
    const answering = globalThis.fetch;
    vi.stubGlobal("fetch", (input: Request) =>
      input.method === "PUT" ? Promise.resolve(refusal()) : answering(input),
    );
    await press("Up: Recording 3");
    await screen.findByText(/The order could not be saved: Busy/);
    return { ...server, answering };
  }

  it("outlives the page, and is saved as soon as possible", async () => {
    const { router, answering, now } = await openRefused();
    await act(() => router.navigate("/elsewhere"));
    await screen.findByText("Another page");
    const leaving = new Event("beforeunload", { cancelable: true });
    window.dispatchEvent(leaving);
    expect(leaving.defaultPrevented).toBe(true);
    await act(() => router.navigate("/"));
    await screen.findByText(/The order could not be saved: Busy/);
    expect(board()).toEqual([["1"], ["3"], ["2"]]);
    await act(() => router.navigate("/elsewhere"));
    vi.stubGlobal("fetch", answering);
    window.dispatchEvent(new Event("online"));
    await waitFor(() => expect(now().tiers).toEqual([[1], [3], [2]]));
    await waitFor(() => expect(readDraft("ranking 1")).toBeUndefined());
  });

  it("is there after a reload, and saved unless another was saved meanwhile", async () => {
    writeDraft("ranking 1", { base: 1, tiers: [[2], [1]] });
    const server = await open({ tiers: [[1], [2], [3]] });
    await waitFor(() => expect(server.now().tiers).toEqual([[2], [1]]));
    cleanup();
    writeDraft("ranking 1", { base: 1, tiers: [[4], [1]] });
    await open({ revision: 7, tiers: [[1], [2], [3]] });
    await screen.findByRole("dialog", { name: /changed elsewhere/ });
  });

  it("can be given up where it is refused for good", async () => {
    await open({ tiers: [[1], [2], [3]] });
    const answering = globalThis.fetch;
    vi.stubGlobal("fetch", (input: Request) =>
      input.method === "PUT"
        ? Promise.resolve(new Response('{"detail": "Recording 3 is gone."}', { status: 422 }))
        : answering(input),
    );
    await press("Up: Recording 3");
    await press("Back to the saved order");
    expect(board()).toEqual([["1"], ["2"], ["3"]]);
    expect(readDraft("ranking 1")).toBeUndefined();
  });
});

describe("ranking by keyboard", () => {
  it("picks up, announces and drops at the place that the arrows lead to", async () => {
    const server = await open({ tiers: [[1], [2], [3]] });
    screen.getByRole("button", { name: "Move Recording 3" }).focus();
    await userEvent.keyboard(" ");
    await screen.findByText("Picked up Recording 3.");
    await userEvent.keyboard("{ArrowUp}{ArrowUp}");
    await screen.findByText("Over tier 2 of 3, with 1 recording.");
    await userEvent.keyboard(" ");
    await waitFor(() => expect(server.now().tiers).toEqual([[1], [2, 3]]));
  });

  it("keeps the order of when it began, says that another arrived, and asks which to keep", async () => {
    const server = await open({ tiers: [[1], [2], [3]] });
    screen.getByRole("button", { name: "Move Recording 4" }).focus();
    await userEvent.keyboard(" ");
    await screen.findByText("Picked up Recording 4.");
    await userEvent.keyboard("{ArrowUp}{ArrowUp}");
    await screen.findByText("Over tier 3 of 3, with 1 recording.");
    server.elsewhere([[3], [2], [1]]);
    await server.client.invalidateQueries({ queryKey: ["ranking"] });
    await screen.findByText(/changed the order. You see it when this drag is over/);
    expect(board()).toEqual([["1"], ["2"], ["3"]]);
    await userEvent.keyboard(" ");
    await screen.findByText("Dropped Recording 4: tier 3 of 3, with 1 recording.");
    await screen.findByRole("dialog", { name: /changed elsewhere/ });
    expect(server.asked.find(({ method }) => method === "PUT")?.body).toEqual({
      base_revision: 1,
      tiers: [[1], [2], [3, 4]],
    });
  });

  it("shows what arrived during a drag that was given up", async () => {
    const server = await open({ tiers: [[1], [2], [3]] });
    screen.getByRole("button", { name: "Move Recording 4" }).focus();
    await userEvent.keyboard(" ");
    await screen.findByText("Picked up Recording 4.");
    server.elsewhere([[3], [2], [1]]);
    await server.client.invalidateQueries({ queryKey: ["ranking"] });
    await screen.findByText(/changed the order. You see it/);
    await userEvent.keyboard("{Escape}");
    await screen.findByText(/changed the order. This is the new one/);
    expect(board()).toEqual([["3"], ["2"], ["1"]]);
  });

  it("leaves it where it was on Escape", async () => {
    const server = await open({ tiers: [[1], [2]] });
    screen.getByRole("button", { name: "Move Recording 2" }).focus();
    await userEvent.keyboard(" ");
    await screen.findByText("Picked up Recording 2.");
    await userEvent.keyboard("{ArrowUp}{Escape}");
    await screen.findByText("Recording 2 stays where it was.");
    expect(server.now().revision).toBe(1);
  });

  it("undoes and redoes", async () => {
    const server = await open({ tiers: [[1], [2]], can_undo: true });
    await press("Up: Recording 2");
    await waitFor(() => expect(server.now().tiers).toEqual([[2], [1]]));
    await userEvent.keyboard("{Control>}z{/Control}");
    await waitFor(() => expect(board()).toEqual([["1"], ["2"]]));
    await userEvent.keyboard("{Control>}{Shift>}z{/Shift}{/Control}");
    await waitFor(() => expect(board()).toEqual([["2"], ["1"]]));
  });

  it("announces what an undo or a redo changed", async () => {
    await open({ tiers: [[1], [2], [3]] });
    await press("Up: Recording 3");
    await screen.findByText("Saved");
    const undo = screen.getByRole("button", { name: "Undo (Ctrl+Z)" });
    await userEvent.click(undo);
    expect(await screen.findByText(/^Undone\./)).toHaveTextContent(
      /^Undone\. Recording \d: tier \d of 3, alone\.$/,
    );
    expect(screen.getByText(/^Undone\./)).toHaveAttribute("role", "status");
    expect(undo).toHaveFocus();
    await press("Redo (Ctrl+Shift+Z)");
    expect(await screen.findByText(/^Redone\./)).toHaveTextContent(
      "Redone. Recording 3: unranked.",
    );
  });

  it("keeps the focus on undo once nothing is left to undo, and announces nothing then", async () => {
    const server = await open({ tiers: [[1], [2]] });
    const undo = screen.getByRole("button", { name: "Undo (Ctrl+Z)" });
    expect(undo).toHaveAttribute("aria-disabled", "true");
    await userEvent.click(undo);
    expect(undo).toHaveFocus();
    expect(server.now().revision).toBe(1);
    expect(screen.queryByText(/^Undone\./)).toBeNull();
  });

  it("is reversed by one button, which an undo takes back", async () => {
    const server = await open({ tiers: [[1], [2, 3], [4]] });
    const turn = screen.getByRole("button", { name: "Reverse the order" });
    turn.focus();
    await userEvent.keyboard("{Enter}");
    expect(board()).toEqual([["4"], ["2", "3"], ["1"]]);
    expect(turn).toHaveFocus();
    expect(screen.getByText("The order is reversed: what was worst is best.")).toBeInTheDocument();
    await waitFor(() => expect(server.now().tiers).toEqual([[4], [2, 3], [1]]));
    await userEvent.keyboard("{Control>}z{/Control}");
    await waitFor(() => expect(board()).toEqual([["1"], ["2", "3"], ["4"]]));
    expect(await screen.findByText("Undone. The order is reversed.")).toBeInTheDocument();
  });

  it("of a single tier cannot be reversed", async () => {
    await open({ tiers: [[1, 2]] });
    expect(screen.getByRole("button", { name: "Reverse the order" })).toBeDisabled();
  });
});

describe("another behaviour's games", () => {
  const LENDER = { name: "Keep left", target: null, built_in: false } as const;

  function openBorrower(refusal?: Refusal) {
    const lent = [21, 22, 23].map((id) =>
      recording({ id, behaviour_id: 2, behaviour_name: LENDER.name, borrowed: true }),
    );
    const all: Recording[] = [];
    let standing = ranking({ tiers: [] });
    const asked = serve({
      ...libraryRoutes(() => all),
      "GET /api/behaviours": () => [
        behaviour(),
        behaviour({ ...LENDER, id: 2, n_ranked: 3 }),
        behaviour({ ...LENDER, id: 3, name: "Stay up", game: "pong", n_ranked: 6 }),
        behaviour({ ...LENDER, id: 4, name: "Nothing ranked", n_ranked: 0 }),
      ],
      "GET /api/behaviours/1/ranking": () => standing,
      "GET /api/behaviours/2/ranking": () => ranking({ behaviour_id: 2, tiers: [[22], [21, 23]] }),
      "POST /api/behaviours/1/ranking/games": () => {
        if (refusal) return refusal;
        all.push(...lent);
        return lent;
      },
      "PUT /api/behaviours/1/ranking": ({ body }: Asked) => {
        const { tiers } = body as { tiers: number[][] };
        standing = ranking({ revision: standing.revision + 1, tiers, can_undo: true });
        return standing;
      },
      "GET /api/behaviours/1/ranking/opinion": () => ({ revision: 0, games: [], wanted: null }),
    });
    show(<RankPage behaviour={behaviour()} />);
    return asked;
  }

  it("are taken over in their order where nothing is ranked yet", async () => {
    const asked = openBorrower();
    const take = await screen.findByRole("button", { name: "Take over the 3 games of Keep left" });
    // The only one of this game with ranked games.
    expect(screen.queryByRole("combobox")).toBeNull();
    await userEvent.click(take);
    await waitFor(() => expect(board()).toEqual([["22"], ["21", "23"]]));
    const sent = asked.filter(({ method }) => method !== "GET");
    expect(sent.map(({ method, path, body }) => [method, path, body])).toEqual([
      ["POST", "/api/behaviours/1/ranking/games", { recording_ids: [22, 21, 23] }],
      ["PUT", "/api/behaviours/1/ranking", { base_revision: 1, tiers: [[22], [21, 23]] }],
    ]);
    expect(screen.queryByRole("button", { name: /^Take over/ })).toBeNull();
  });

  it("that are refused leave the board empty and say why", async () => {
    openBorrower(new Refusal(409, { detail: "Nothing was added: recording 22 is deleted." }));
    await userEvent.click(await screen.findByRole("button", { name: /^Take over the 3 games/ }));
    expect(
      await screen.findByText("Nothing was added: recording 22 is deleted."),
    ).toBeInTheDocument();
    expect(screen.getByText("Nothing to rank yet")).toBeVisible();
  });
});

describe("varied games", () => {
  it("are added and marked, and those without a target put below the worst in one revision", async () => {
    const server = await open({ tiers: [[1], [2]] });
    await press("Add varied games");
    const done = "3 varied games added, 2 of them selected: those that hit no target.";
    expect((await screen.findAllByText(done))[0]).toBeInTheDocument();
    const borrowed = within(
      await screen.findByRole("article", { name: "Recording 11 of Column 2" }),
    );
    expect(borrowed.getByText("from Column 2")).toBeVisible();
    expect(borrowed.queryByRole("button", { name: /perfect/ })).toBeNull();
    const varied = within(await screen.findByRole("article", { name: "Recording 12" }));
    expect(varied.getByText("varied play")).toBeVisible();
    await press("Put below the worst");
    expect(board()).toEqual([["1"], ["2"], ["12", "11"]]);
    expect(screen.getByText("Dropped 2 recordings: new tier, worst of all.")).toBeInTheDocument();
    expect(screen.queryByRole("group", { name: "Selected recordings" })).toBeNull();
    expect(screen.getByRole("button", { name: "Move Recording 12" })).toHaveFocus();
    await waitFor(() =>
      expect(server.now()).toMatchObject({ revision: 2, tiers: [[1], [2], [12, 11]] }),
    );
    expect(server.asked.find(({ method }) => method === "POST")?.body).toEqual({ count: 24 });
  });

  it("can be selected again, and given back", async () => {
    await open({ tiers: [[1], [2]] });
    await press("Add varied games");
    await screen.findByText("2 recordings selected");
    await press("Select none");
    expect(screen.queryByText(/recordings selected/)).toBeNull();
    await press("Select all varied (3)");
    expect(
      await screen.findByRole("checkbox", { name: "Select Recording 11 of Column 2" }),
    ).toBeChecked();
    expect(screen.getByRole("checkbox", { name: "Select Recording 3" })).not.toBeChecked();
    await press("Give back: Recording 11 of Column 2");
    await waitFor(() =>
      expect(screen.queryByRole("article", { name: "Recording 11 of Column 2" })).toBeNull(),
    );
    expect(screen.getByText("2 recordings selected")).toBeVisible();
  });

  it("are not those of a run's policy, which name the run", async () => {
    const runId = "3f2a9c00-0000-4000-8000-000000000000";
    const played = recording({ id: 14, source: "policy", run_id: runId, borrowed: true });
    await open({ tiers: [[1], [2]] }, undefined, [played]);
    const card = within(screen.getByRole("article", { name: "Recording 14 of Run 3f2a9c" }));
    expect(card.getByText("from Run 3f2a9c")).toBeVisible();
    expect(card.queryByRole("button", { name: /perfect/ })).toBeNull();
    expect(
      card.getByRole("button", { name: "Give back: Recording 14 of Run 3f2a9c" }),
    ).toBeVisible();
    expect(screen.queryByRole("button", { name: /Select all varied/ })).toBeNull();
  });

  it("say why they could not be added", async () => {
    const server = await open({ tiers: [[1], [2]] });
    serve({
      "POST /api/behaviours/1/borrowed": () => new Refusal(503, { detail: "Too much to do." }),
    });
    await press("Add varied games");
    expect(await screen.findByText("Too much to do.")).toBeVisible();
    expect(screen.getByRole("button", { name: "Add varied games" })).toBeVisible();
    expect(server.now().revision).toBe(1);
  });
});

describe("several selected recordings", () => {
  const select = (id: number) =>
    userEvent.click(screen.getByRole("checkbox", { name: `Select Recording ${id}` }));

  it("go into a tier that is chosen, and an undo brings all of them back", async () => {
    const server = await open({ tiers: [[1], [2]] });
    await select(3);
    await select(4);
    await userEvent.selectOptions(
      screen.getByRole("combobox", { name: "Tier to put them into" }),
      "Tier 1, best",
    );
    await press("Put into tier 1");
    expect(board()).toEqual([["1", "3", "4"], ["2"]]);
    expect(
      screen.getByText("Dropped 2 recordings: tier 1 of 2, with 1 recording."),
    ).toBeInTheDocument();
    await waitFor(() => expect(server.now().revision).toBe(2));
    await press("Undo (Ctrl+Z)");
    await waitFor(() => expect(board()).toEqual([["1"], ["2"]]));
  });

  it("are taken off the board by keyboard alone", async () => {
    const server = await open({ tiers: [[1], [2], [3]] });
    screen.getByRole("checkbox", { name: "Select Recording 4" }).focus();
    await userEvent.keyboard(" ");
    expect(screen.queryByRole("button", { name: "Take off the board" })).toBeNull();
    await userEvent.keyboard(" ");
    screen.getByRole("checkbox", { name: "Select Recording 2" }).focus();
    await userEvent.keyboard(" ");
    screen.getByRole("button", { name: "Take off the board" }).focus();
    await userEvent.keyboard("{Enter}");
    expect(board()).toEqual([["1"], ["3"]]);
    expect(screen.getByText("Dropped 1 recording: unranked.")).toBeInTheDocument();
    await waitFor(() => expect(server.now().tiers).toEqual([[1], [3]]));
  });
});

describe("what the other games suggest", () => {
  const game = (change: Partial<GameOpinion>): GameOpinion => ({
    recording_id: 1,
    place: 0.3,
    best_place: 0.1,
    worst_place: 0.5,
    tier: 1,
    best_tier: 1,
    worst_tier: 2,
    contradicted_by: [],
    ...change,
  });
  const card = (id: number) => within(screen.getByRole("article", { name: `Recording ${id}` }));
  const contradiction = { recording_id: 3, tier: 1, worst_tier: 1, contradicted_by: [1, 2] };

  it("is shown beside ranked and unranked games", async () => {
    await open({ tiers: [[1], [2], [3]] }, () => ({
      games: [game({}), game({ recording_id: 4, tier: 2, best_tier: 2 })],
    }));
    expect(await screen.findByText("The others suggest tier 1 (1 to 2)")).toBeVisible();
    expect(card(4).getByText("Probably tier 2")).toBeVisible();
    expect(card(2).queryByText(/suggest/)).toBeNull();
    await userEvent.click(screen.getByText("How to read this"));
    expect(screen.getByText(/A wide band means unsure/)).toBeVisible();
  });

  it("names a contradiction and moves the game where they suggest", async () => {
    let games = [game(contradiction)];
    const server = await open({ tiers: [[1], [2], [3]] }, () => ({ games }));
    await userEvent.click(await screen.findByText("The others suggest tier 1"));
    expect(
      await screen.findByText(
        "By what it hits, it belongs higher: about tier 1. It is " +
          "no worse than Recording 1 and Recording 2.",
      ),
    ).toBeVisible();
    games = [];
    card(3).getByRole("button", { name: "Move to tier 1: Recording 3" }).focus();
    await userEvent.keyboard("{Enter}");
    expect(board()).toEqual([["1", "3"], ["2"]]);
    expect(screen.getByText("Recording 3: tier 1 of 2, tied with 1.")).toBeInTheDocument();
    await waitFor(() => expect(server.now().tiers).toEqual([[1, 3], [2]]));
    await waitFor(() => expect(screen.queryByText(/By what it hits, it belongs/)).toBeNull());
  });

  it("moves nothing by tiers of another order", async () => {
    const server = await open({ tiers: [[1], [2], [3]] }, () => ({
      revision: 7,
      games: [game(contradiction)],
    }));
    await userEvent.click(await screen.findByText("The others suggest tier 1"));
    const move = await screen.findByRole("button", { name: "Move to tier 1: Recording 3" });
    expect(move).toHaveAttribute("aria-disabled", "true");
    await userEvent.click(move);
    expect(server.asked.filter(({ method }) => method === "PUT")).toEqual([]);
  });

  it("can be declined for a game, and hidden for all", async () => {
    const server = await open({ tiers: [[1], [2], [3]] }, () => ({
      games: [game(contradiction)],
    }));
    await userEvent.click(await screen.findByText("The others suggest tier 1"));
    await userEvent.click(await screen.findByRole("button", { name: "Keep it here: Recording 3" }));
    expect(screen.queryByRole("group", { name: "Contradiction at Recording 3" })).toBeNull();
    expect(card(3).getByRole("button", { name: "Move Recording 3" })).toHaveFocus();
    expect(card(3).getByText("The others suggest tier 1")).toBeVisible();
    await userEvent.click(
      screen.getByRole("checkbox", { name: "Show what the other games suggest" }),
    );
    expect(card(3).queryByText(/suggest/)).toBeNull();
    expect(server.now().revision).toBe(1);
  });

  it("says which aliens the order asks for, until it is hidden", async () => {
    await open({ tiers: [[1], [2], [3]] });
    const wanted = within(await screen.findByRole("region", { name: "What this order asks for" }));
    expect(wanted.getByRole("img")).toHaveAccessibleName(/^To be hit: row 1, column 2/);
    expect(wanted.getByText(/Unsure about 1 alien/)).toBeVisible();
    await userEvent.click(
      screen.getByRole("checkbox", { name: "Show what the other games suggest" }),
    );
    expect(screen.queryByRole("region", { name: "What this order asks for" })).toBeNull();
  });

  it("is asked again after each saved change", async () => {
    const server = await open({ tiers: [[1], [2], [3]] });
    await screen.findByRole("region", { name: "What this order asks for" });
    const times = () => server.asked.filter(({ path }) => path.endsWith("/opinion")).length;
    const before = times();
    await press("Up: Recording 3");
    await waitFor(() => expect(times()).toBe(before + 1));
  });

  it("says what it needs, and what went wrong", async () => {
    let more: Partial<RankingOpinion> = { wanted: null };
    await open({ tiers: [[1], [2]] }, () => more);
    expect(await screen.findByText(/Rank four games in at least two tiers/)).toBeVisible();
    more = {};
    serve({
      "PUT /api/behaviours/1/ranking": () => ranking({ revision: 2, tiers: [[2], [1]] }),
      "GET /api/behaviours/1/ranking/opinion": () =>
        new Refusal(503, { detail: "Too much to do." }),
    });
    await press("Up: Recording 2");
    expect(await screen.findByText("It could not be worked out: Too much to do.")).toBeVisible();
  });
});

describe("two tabs", () => {
  it("see both orders and choose one", async () => {
    const server = await open({ tiers: [[1], [2]] });
    server.elsewhere([[1], [2], [3]]);
    await press("Up: Recording 2");
    const dialog = within(await screen.findByRole("dialog", { name: /changed elsewhere/ }));
    const theirs = within(dialog.getByRole("region", { name: "Saved elsewhere" }));
    expect(theirs.getAllByRole("listitem")).toHaveLength(3);
    await userEvent.click(dialog.getByRole("button", { name: "Use mine" }));
    await waitFor(() => expect(server.now()).toMatchObject({ revision: 3, tiers: [[2], [1]] }));
    expect(screen.queryByRole("dialog")).toBeNull();
  });

  it("can take the other one", async () => {
    const server = await open({ tiers: [[1], [2]] });
    server.elsewhere([[1, 2, 3]]);
    await press("Up: Recording 2");
    await userEvent.click(await screen.findByRole("button", { name: "Keep theirs" }));
    expect(board()).toEqual([["1", "2", "3"]]);
    expect(server.now().revision).toBe(2);
  });
});

/** Unfolds what training needs, and returns queries in it. */
async function unfoldNeeds() {
  const needs = within(screen.getByRole("region", { name: "What training needs" }));
  await userEvent.click(needs.getByText("What training needs"));
  return needs;
}

describe("what training needs", () => {
  it("is listed while it is missing", async () => {
    await open({ tiers: [[1, 2]] });
    const hints = within(screen.getByRole("region", { name: "What training needs" }));
    expect(hints.getByText(/Make at least two tiers/)).toBeVisible();
    expect(hints.queryByRole("link", { name: "Continue to Train" })).toBeNull();
    await press("Own tier: Recording 2");
    expect(hints.getByText("1 comparison to learn from")).not.toBeVisible();
    await unfoldNeeds();
    expect(hints.getByText("1 comparison to learn from")).toBeVisible();
    expect(hints.getByRole("link", { name: "Continue to Train" })).toBeVisible();
  });

  it("is enough with four ranked games and three that are marked as perfect", async () => {
    const games = Array.from({ length: 7 }, (_, at) => recording({ id: 10 + at, perfect: at > 4 }));
    const tiers = [[10], [11], [12]];
    await open({ tiers }, undefined, games);
    const hints = await unfoldNeeds();
    expect(hints.getByText("3 marked as perfect")).toBeVisible();
    expect(hints.getByText(/^3 games ranked\. Four/)).toBeVisible();
    await press("Rank as worst: Recording 13");
    expect(hints.getByText(/^4 games ranked: enough once/)).toBeVisible();
  });

  it.each([
    [0, /^1 game has a star\. Star at least three/],
    [1, /^2 games have a star\. Star at least three/],
  ])("asks for more stars where there is one and %i more", async (nMore, text) => {
    const games = Array.from({ length: 4 }, (_, at) =>
      recording({ id: 10 + at, perfect: at < nMore }),
    );
    await open({ tiers: [[10], [11]] }, undefined, games);
    const hints = await unfoldNeeds();
    expect(hints.getByText(text)).toBeVisible();
    expect(hints.getByRole("link", { name: "Continue to Train" })).toBeVisible();
  });

  it("says nothing of hits where the behaviour has no target", async () => {
    rankingServer({ tiers: [[1], [2]] });
    show(<RankPage behaviour={behaviour({ n_recordings: 4, target: null })} />);
    await screen.findByRole("region", { name: "What training needs" });
    const hints = await unfoldNeeds();
    expect(hints.getByText(/the imitator begins by copying them\.$/)).toBeVisible();
    expect(hints.queryByText(/\bhit\b/)).toBeNull();
    const card = within(await screen.findByRole("article", { name: "Recording 2" }));
    expect(card.getByText(/survived all 300 steps/)).toBeVisible();
    expect(card.queryByText(/alien|target/)).toBeNull();
  });

  it("begins with a game", async () => {
    serve({
      "GET /api/behaviours/1/ranking": () => ranking(),
      ...libraryRoutes(() => []),
    });
    show(<RankPage behaviour={behaviour()} />);
    expect(await screen.findByRole("link", { name: "Play a game" })).toHaveAttribute(
      "href",
      "/behaviours/1/play",
    );
  });
});
