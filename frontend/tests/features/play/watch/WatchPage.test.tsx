import { act, screen, waitFor, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";

import { WatchPage } from "@/features/play/watch/WatchPage";
import { SilenceWatch } from "@/lib/browser/silence";

import { behaviour, run } from "../../../support/data";
import { show } from "../../../support/page";
import { WATCH_HELLO, WatchSocket } from "../../../support/watch-socket";

const RUN = run({ status: "done" });

function watch(search = "?player=imitator.greedy&start=3") {
  return show(<WatchPage run={RUN} behaviour={behaviour()} />, `/${search}`);
}

function tell(message: object): void {
  act(() => WatchSocket.newest.tell(message));
}

beforeEach(() => {
  // The server of these tests says nothing by itself, and their machine may stand still.
  vi.spyOn(SilenceWatch.prototype, "start").mockReturnValue();
  sessionStorage.clear();
  vi.stubGlobal("WebSocket", WatchSocket);
  WatchSocket.opened.length = 0;
});

afterEach(() => vi.unstubAllGlobals());

describe("the page that watches", () => {
  it("asks for what its address says, and shows pause, step and speed", async () => {
    watch("?player=imitator.greedy&player=clone.sampled&start=3");
    const { url } = WatchSocket.newest;
    expect(url.pathname).toBe(`/api/runs/${RUN.id}/watch`);
    expect(url.searchParams.getAll("player")).toEqual(["imitator.greedy", "clone.sampled"]);
    expect(url.searchParams.get("start")).toBe("3");
    tell(WATCH_HELLO);
    tell({ type: "playing" });
    expect(screen.getByText("Evaluation start 3, after an opening of 1.6 s")).toBeVisible();
    await userEvent.click(screen.getByRole("button", { name: /^Pause/ }));
    tell({ type: "paused", why: "" });
    await userEvent.click(screen.getByRole("button", { name: /^One step/ }));
    await userEvent.click(screen.getByRole("button", { name: "25%" }));
    expect(WatchSocket.newest.commands).toEqual([
      { type: "play" },
      { type: "pause" },
      { type: "step" },
      { type: "speed", percent: 25 },
    ]);
    expect(screen.getByRole("button", { name: "25%" })).toHaveAttribute("aria-pressed", "true");
  });

  it("shows what policies or the reward look at over the games, until that is switched off", async () => {
    watch();
    tell(WATCH_HELLO);
    tell({ type: "playing" });
    const choice = screen.getByRole("combobox", { name: "Over the picture" });
    await userEvent.selectOptions(choice, "What imitator and clone look at");
    const shares = btoa(String.fromCharCode(...new Uint8Array(84 * 84).fill(255)));
    const map = { type: "attention", lane: 0, frame: 96, most: 0.25, action: 3, shares };
    tell(map);
    expect(screen.getByRole("img", { name: "What the imitator looks at" })).toBeVisible();
    expect(screen.getByText("up to 0.25 logits")).toBeVisible();
    await userEvent.selectOptions(choice, "What the reward looks at");
    expect(screen.queryByRole("img", { name: /looks at/ })).toBeNull();
    tell({ ...map, action: null, most: 0.5 });
    expect(screen.getByText("up to 0.50 R")).toBeVisible();
    await userEvent.selectOptions(choice, "Picture only");
    expect(screen.queryByRole("img", { name: /looks at/ })).toBeNull();
    expect(WatchSocket.newest.commands.slice(1)).toEqual([
      { type: "attention", network: "policy" },
      { type: "attention", network: "reward" },
      { type: "attention", network: null },
    ]);
  });

  it("obeys the keys, but not while a list of choices has the focus", async () => {
    watch();
    tell(WATCH_HELLO);
    tell({ type: "playing" });
    await userEvent.keyboard(".");
    tell({ type: "paused", why: "" });
    await userEvent.keyboard(".");
    screen.getByRole("combobox", { name: "Start" }).focus();
    await userEvent.keyboard(".");
    expect(WatchSocket.newest.commands).toEqual([
      { type: "play" },
      { type: "pause" },
      { type: "step" },
    ]);
  });

  it("shows decisions, hits and the end of each game", () => {
    watch();
    tell(WATCH_HELLO);
    tell({
      type: "decision",
      lane: 0,
      frame: 96,
      action: 1,
      probabilities: [0.1, 0.7, 0, 0.2, 0, 0],
    });
    tell({ type: "reward", lane: 0, frame: 96, level: -0.25, deviation: 0.08 });
    tell({ type: "hit", lane: 0, row: 0, column: 0, frame: 99, on_target: true });
    const lane = screen.getByRole("article", { name: "Game 1: Imitator, greedy" });
    const shares = within(lane).getAllByRole("listitem");
    expect(shares.find((row) => row.hasAttribute("data-chosen"))).toHaveTextContent("fire70%");
    expect(lane).toHaveTextContent("Reward R −0.25 ± 0.08");
    expect(lane).toHaveTextContent("Targets hit1 of 2");
    tell({
      type: "ended",
      lane: 0,
      reason: "hit",
      frame: 300,
      hits: [],
      targets: 0,
      strays: 0,
      order_errors: null,
    });
    expect(within(lane).getByText("Hit by a bomb after 5.0 s")).toBeVisible();
    expect(within(lane).getByRole("button", { name: /Take over/ })).toBeDisabled();
  });

  it("watches another player, and one more beside it", async () => {
    watch();
    await userEvent.selectOptions(
      screen.getByRole("combobox", { name: "Who plays game 1" }),
      "Clone, greedy",
    );
    await userEvent.click(screen.getByRole("button", { name: "Add another beside it" }));
    await waitFor(() =>
      expect(WatchSocket.newest.url.searchParams.getAll("player")).toEqual([
        "clone.greedy",
        "imitator.greedy",
      ]),
    );
    await userEvent.click(screen.getByRole("button", { name: "Remove game 1" }));
    expect(WatchSocket.newest.url.searchParams.getAll("player")).toEqual(["imitator.greedy"]);
    expect(WatchSocket.opened.slice(0, -1).every((one) => one.readyState === 3)).toBe(true);
  });

  it("restarts on the same start, and goes on to the next", async () => {
    watch();
    await userEvent.click(screen.getByRole("button", { name: /^Restart/ }));
    const restarted = WatchSocket.newest.url.searchParams;
    expect([restarted.get("start"), restarted.get("take")]).toEqual(["3", "1"]);
    await userEvent.click(screen.getByRole("button", { name: /^Next start/ }));
    expect(WatchSocket.newest.url.searchParams.get("start")).toBe("4");
    await userEvent.selectOptions(screen.getByRole("combobox", { name: "Start" }), "new");
    expect(WatchSocket.newest.url.searchParams.get("start")).toBeNull();
    expect(WatchSocket.newest.url.searchParams.get("draw")).toMatch(/^\d+$/);
  });

  it("goes on with a game that was taken over on the play page", async () => {
    const { router } = watch();
    tell(WATCH_HELLO);
    tell({ type: "playing" });
    await userEvent.keyboard("[KeyT]");
    expect(WatchSocket.newest.commands.at(-1)).toEqual({ type: "take_over", lane: 0 });
    tell({ type: "taken", lane: 0, game_id: "abc", behaviour_id: 1 });
    await waitFor(() => expect(router.state.location.pathname).toBe("/behaviours/1/play"));
    expect(sessionStorage.getItem("tril.game.1")).toBe("abc");
  });

  it.each([
    [{ type: "paused", why: "The inference process is not running." }, /not running/],
    [{ type: "refused", why: "This training has no imitator yet." }, /no imitator yet/],
    [{ type: "waiting" }, /Waiting for the next decision/],
  ])("says what keeps it from playing: %j", (message, words) => {
    watch();
    tell(message);
    expect(screen.getByText(words)).toBeVisible();
  });
});
