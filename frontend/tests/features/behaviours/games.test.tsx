import { screen, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { describe, expect, it } from "vitest";

import type { TaughtGame } from "@/api/types";
import { GamePage } from "@/features/behaviours/games/GamePage";
import { GamesPage } from "@/features/behaviours/games/GamesPage";
import { cardAt, foundGames } from "@/features/behaviours/games/search";

import { behaviour } from "../../support/data";
import {
  CART_POLE,
  gameRoutes,
  MS_PACMAN,
  PONG,
  SPACE_INVADERS,
  titleOf,
} from "../../support/games";
import { show } from "../../support/page";
import { serve } from "../../support/server";

const UNSAVED = { ...CART_POLE, saves_states: false };
const ALL = [PONG, MS_PACMAN, UNSAVED, SPACE_INVADERS];
const OWNER = { "GET /api/player": () => ({ id: 1, name: "Ada", role: "owner" }) };

describe("finding a game", () => {
  it.each([
    ["", ["Pong", "Ms. Pac-Man", "CartPole", "Space Invaders"]],
    ["PACMAN", ["Ms. Pac-Man"]],
    ["pac man", ["Ms. Pac-Man"]],
    ["invaders space", ["Space Invaders"]],
    ["gym", ["CartPole"]],
    ["chess", []],
  ])("by %j finds %j", (typed, titles) => {
    const games = ALL.map((game) => titleOf(game));
    expect(foundGames(games, typed).map(({ title }) => title)).toEqual(titles);
  });

  it("moves among the cards by arrow keys and stays among them", () => {
    expect(cardAt(0, "ArrowRight", 3, 7)).toBe(1);
    expect(cardAt(1, "ArrowDown", 3, 7)).toBe(4);
    expect(cardAt(5, "ArrowDown", 3, 7)).toBe(5);
    expect(cardAt(5, "End", 3, 7)).toBe(6);
    expect(cardAt(5, "Home", 3, 7)).toBe(0);
    expect(cardAt(0, "a", 3, 7)).toBeNull();
  });
});

describe("the page of games", () => {
  it("shows all in the server's order, and those that are typed", async () => {
    serve({
      "GET /api/catalogue": () => [
        titleOf(MS_PACMAN, { n_behaviours: 2 }),
        ...[PONG, SPACE_INVADERS].map((game) => titleOf(game)),
      ],
    });
    const { router } = show(<GamesPage />);
    const cards = await screen.findAllByRole("listitem");
    expect(cards.map((card) => card.textContent)).toEqual([
      "Ms. Pac-Man2 behaviours",
      "Pong",
      "Space Invaders",
    ]);
    expect(cards[0]?.querySelector("img")).toHaveAttribute("loading", "lazy");
    await userEvent.type(screen.getByRole("searchbox", { name: "Find a game" }), "po");
    expect(screen.getAllByRole("listitem")).toHaveLength(1);
    await userEvent.keyboard("{Enter}");
    expect(router.state.location.pathname).toBe("/games/pong");
  });

  it("says that there is no game of a name", async () => {
    serve({});
    show(<GamesPage />);
    await userEvent.type(await screen.findByRole("searchbox"), "chess");
    expect(screen.getByRole("heading", { name: "No game of this name" })).toBeVisible();
  });

  it("moves the focus by arrow keys", async () => {
    serve(gameRoutes(...ALL));
    show(<GamesPage />);
    const [first, second] = await screen.findAllByRole("link");
    first?.focus();
    await userEvent.keyboard("{ArrowRight}");
    expect(second).toHaveFocus();
  });
});

function open(game: TaughtGame, behaviours = [behaviour()]) {
  const asked = serve({
    ...gameRoutes(...ALL),
    ...OWNER,
    "GET /api/behaviours": () => behaviours,
    "POST /api/behaviours": () => behaviour({ id: 9, game: game.name }),
  });
  return { asked, ...show(<GamePage name={game.name} />) };
}

describe("the page of a game", () => {
  it("shows its behaviours, and teaches another one in it", async () => {
    const left = behaviour({ id: 4, name: "Lower half", game: "ms_pacman", target: null });
    const { asked, router } = open(MS_PACMAN, [behaviour(), left]);
    const list = within(await screen.findByRole("list", { name: "Behaviours" }));
    expect(list.getAllByRole("listitem")).toHaveLength(1);
    expect(list.getByRole("link", { name: "Lower half" })).toHaveAttribute("href", "/behaviours/4");
    await userEvent.click(await screen.findByRole("button", { name: "Teach a behaviour" }));
    const dialog = within(screen.getByRole("dialog", { name: "Teach a behaviour in Ms. Pac-Man" }));
    await userEvent.type(dialog.getByLabelText("Description"), "Never miss.");
    await userEvent.type(dialog.getByLabelText("Name"), "Keep level");
    expect(
      await dialog.findByRole("option", { name: "Ms. Pac-Man", selected: true }),
    ).toBeVisible();
    expect(dialog.queryByRole("checkbox")).toBeNull();
    await userEvent.click(dialog.getByText("How it is played"));
    const seconds = dialog.getByLabelText("Longest game, in seconds");
    await userEvent.type(seconds, "3");
    await userEvent.click(dialog.getByRole("button", { name: "Create behaviour" }));
    expect(seconds).toHaveAccessibleDescription("Type a number of seconds from 5 to 400.");
    await userEvent.type(seconds, "0");
    await userEvent.selectOptions(dialog.getByLabelText("It also ends"), "when the game is over");
    await userEvent.selectOptions(dialog.getByLabelText("Mode"), "2");
    await userEvent.click(dialog.getByRole("button", { name: "Create behaviour" }));
    await screen.findByText("Another page");
    expect(router.state.location.pathname).toBe("/behaviours/9/play");
    expect(asked.find(({ method }) => method === "POST")?.body).toEqual({
      game: "ms_pacman",
      name: "Keep level",
      description: "Never miss.",
      target: null,
      ordered: false,
      settings: { max_steps: 450, end_rule: "over", options: { mode: 2 }, hidden: null },
      measures: [],
    });
  });

  it("says what a game lacks, and why", async () => {
    open(UNSAVED, []);
    expect(await screen.findByText("Nothing has been taught in it yet.")).toBeVisible();
    expect(screen.getByText(/Its buttons: left, right. 50 frames/)).toBeVisible();
    for (const lack of [/stands still until/, /no targets/, /no examples/, /rewound/, /no memory/])
      expect(screen.getByText(lack)).toBeVisible();
  });

  it("says nothing of the kind of a game that lacks nothing", async () => {
    open(SPACE_INVADERS);
    expect(await screen.findByText(/Its buttons: left, right, fire/)).toBeVisible();
    expect(screen.queryByText(/no examples|rewound|no memory|no targets/)).toBeNull();
  });

  it("says that there is no such game", async () => {
    serve({ ...OWNER, "GET /api/behaviours": () => [] });
    show(<GamePage name="chess" />);
    expect(await screen.findByRole("heading", { name: "Game not found" })).toBeVisible();
  });
});
