import { cleanup, screen, waitFor, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { describe, expect, it } from "vitest";

import { HomePage } from "@/features/behaviours/HomePage";

import { behaviour, headline, recipe, run, system } from "../../support/data";
import { SPACE_INVADERS } from "../../support/games";
import { show } from "../../support/page";
import { Refusal, serve } from "../../support/server";

const INTERVAL = { mean: 1.74, low: 1.3, high: 2, n: 23 };
const SUMMARY = {
  targets: INTERVAL,
  strays: INTERVAL,
  order_errors: null,
  steps: INTERVAL,
  death_rate: INTERVAL,
  predicted_return: null,
};
const HEADLINE = headline({ imitator: SUMMARY, clone: SUMMARY });

const OWNER = { "GET /api/player": () => ({ id: 1, name: "Ada", role: "owner" }) };

describe("the first page", () => {
  it("says what Tril is and where to begin, before anything was played", async () => {
    const asked = serve({
      "GET /api/behaviours": () => [behaviour()],
      "GET /api/runs": () => [],
      "GET /api/recipes": () => [recipe()],
      "POST /api/runs": () => run({ id: "r1", example: true }),
    });
    const { router } = show(<HomePage />);
    const play = await screen.findByRole("link", { name: "Play your first game" });
    expect(play).toHaveAttribute("href", "/behaviours/1/play");
    const example = await screen.findByRole("button", {
      name: /Train an example \(about 12\u00a0min\)/,
    });
    await userEvent.click(example);
    await screen.findByText("Another page");
    expect(router.state.location.pathname).toBe("/runs/r1");
    expect(asked.find(({ method }) => method === "POST")?.body).toMatchObject({
      behaviour_id: 1,
      example: true,
      go_on_anyway: true,
      device: "any",
      steps: 300_000,
    });
  });

  it("shows a picture of the game beside other games, with the targets, too", async () => {
    serve({
      ...OWNER,
      "GET /api/behaviours": () => [
        behaviour({ n_recordings: 1, target: [[0, 0]] }),
        behaviour({ id: 2, name: "Stay up", game: "pong", target: null }),
      ],
      "GET /api/runs": () => [],
      "GET /api/catalogue/games/space_invaders": () => SPACE_INVADERS,
      "GET /api/catalogue/games/pong": () => ({ ...SPACE_INVADERS, name: "pong", items: null }),
    });
    show(<HomePage />);
    const [card] = await screen.findAllByRole("article");
    await waitFor(() =>
      expect(card?.querySelector("img")).toHaveAttribute("src", SPACE_INVADERS.picture_url),
    );
    expect(card?.querySelector("svg")).not.toBeNull();
  });

  it("lists the behaviours that people made before those that ship with Tril", async () => {
    const list = [
      behaviour(),
      behaviour({ id: 2, slug: "row-1", name: "Row 1" }),
      behaviour({ id: 3, slug: "left", name: "Stay on the left", built_in: false }),
    ];
    serve({ "GET /api/behaviours": () => list, "GET /api/runs": () => [], ...OWNER });
    show(<HomePage />);
    await screen.findByRole("link", { name: "Stay on the left" });
    const names = screen.getAllByRole("article").map((card) => within(card).getByRole("heading"));
    expect(names.map(({ textContent }) => textContent)).toEqual([
      "Stay on the left",
      "Column 1",
      "Row 1",
    ]);
  });

  it("opens the finished example that ships with Tril, if one does", async () => {
    const asked = serve({
      "GET /api/behaviours": () => [behaviour()],
      "GET /api/runs": () => [],
      "GET /api/recipes": () => [recipe()],
      "GET /api/system": () => ({ ...system(true), has_example: true }),
      "POST /api/example": () => run({ id: "r7", status: "done", example: true, imported: true }),
    });
    const { router } = show(<HomePage />);
    await userEvent.click(
      await screen.findByRole("button", { name: "Open a finished example (at once)" }),
    );
    await screen.findByText("Another page");
    expect(router.state.location.pathname).toBe("/runs/r7");
    expect(asked.filter(({ method }) => method === "POST")).toHaveLength(1);
  });

  it("still says where to begin when only an example was opened", async () => {
    const untouched = behaviour({ id: 2, name: "Column 2" });
    const example = behaviour({ n_recordings: 24, n_ranked: 12, n_runs: 1, has_example: true });
    const open = (one: ReturnType<typeof run>) => {
      serve({
        ...OWNER,
        "GET /api/behaviours": () => [example, untouched],
        "GET /api/runs": () => [one],
        "GET /api/recipes": () => [recipe()],
      });
      return show(<HomePage />);
    };
    open(run({ status: "done", example: true }));
    const play = await screen.findByRole("link", { name: "Play your first game" });
    expect(play).toHaveAttribute("href", "/behaviours/2/play");
    expect(screen.queryByRole("button", { name: /Train an example/ })).toBeNull();
    cleanup();
    open(run({ status: "done" }));
    expect(await screen.findByRole("heading", { level: 1, name: "Behaviours" })).toBeVisible();
    expect(screen.queryByRole("link", { name: "Play your first game" })).toBeNull();
  });

  it("has no button for an example that does not ship", async () => {
    const asked = serve({
      "GET /api/behaviours": () => [behaviour()],
      "GET /api/runs": () => [],
      "GET /api/recipes": () => [recipe()],
      "GET /api/system": () => system(true),
    });
    show(<HomePage />);
    await screen.findByRole("button", { name: /Train an example/ });
    await waitFor(() => expect(asked.some(({ path }) => path === "/api/system")).toBe(true));
    expect(screen.queryByRole("button", { name: /Open a finished example/ })).toBeNull();
  });

  it("shows the latest run's headline with its interval afterwards", async () => {
    serve({
      ...OWNER,
      "GET /api/behaviours": () => [
        behaviour({ n_recordings: 12, n_ranked: 12, n_perfect: 3, n_runs: 1 }),
      ],
      "GET /api/runs": () => [
        run({
          status: "done",
          headline: HEADLINE,
        }),
      ],
    });
    show(<HomePage />);
    const card = await screen.findByRole("article");
    expect(within(card).getByText("12 recordings, 12 ranked, 3 starred, 1 run")).toBeVisible();
    expect(await within(card).findByText("Imitator hits 1.7 of 2 (1.3 to 2.0)")).toBeVisible();
    expect(screen.queryByRole("link", { name: "Play your first game" })).toBeNull();
  });

  it("shows how much of what was understood is played where there are no targets", async () => {
    const share = (mean: number) => ({ mean, low: mean, high: mean, n: 23 });
    const understood = { imitator: share(0.88), clone: null, best: share(0.31), read: null };
    serve({
      ...OWNER,
      "GET /api/behaviours": () => [behaviour({ target: null, n_recordings: 8, n_runs: 1 })],
      "GET /api/runs": () => [run({ status: "done", headline: { ...HEADLINE, understood } })],
    });
    show(<HomePage />);
    const card = await screen.findByRole("article");
    expect(await within(card).findByText("Imitator 88%, by what Tril understood")).toBeVisible();
    expect(within(card).getByText("Your best games 31%")).toBeVisible();
  });

  it("shows the last result where the latest run was cancelled", async () => {
    serve({
      ...OWNER,
      "GET /api/behaviours": () => [behaviour({ n_recordings: 12, n_runs: 2 })],
      "GET /api/recipes": () => [recipe()],
      "GET /api/runs": () => [
        run({ id: "r2", status: "cancelled", headline: null }),
        run({ id: "r1", status: "done", headline: HEADLINE }),
      ],
    });
    show(<HomePage />);
    const card = await screen.findByRole("article");
    expect(await within(card).findByText(/^Imitator hits 1\.7 of 2/)).toBeVisible();
  });

  it("says why it can't show anything, and tries again", async () => {
    let broken = true;
    serve({
      "GET /api/behaviours": () =>
        broken ? new Refusal(503, { detail: "The database is busy." }) : [behaviour()],
      "GET /api/runs": () => [],
      "GET /api/recipes": () => [recipe()],
    });
    show(<HomePage />);
    expect(await screen.findByRole("alert")).toHaveTextContent("The database is busy.");
    broken = false;
    await userEvent.click(screen.getByRole("button", { name: "Try again" }));
    expect(await screen.findByRole("heading", { name: "Column 1" })).toBeVisible();
  });
});

describe("a new behaviour", () => {
  async function open(answer: () => unknown) {
    const asked = serve({
      "GET /api/behaviours": () => [behaviour({ n_recordings: 1 })],
      "GET /api/runs": () => [],
      "POST /api/behaviours": answer,
    });
    const { router } = show(<HomePage />);
    await userEvent.click(await screen.findByRole("button", { name: "New behaviour" }));
    const dialog = within(screen.getByRole("dialog", { name: "New behaviour" }));
    const sent = () => asked.find(({ method }) => method === "POST")?.body;
    return { dialog, router, sent };
  }

  it("needs a name", async () => {
    const { dialog, sent } = await open(() => behaviour());
    await userEvent.click(dialog.getByRole("button", { name: "Create behaviour" }));
    expect(dialog.getByLabelText("Name")).toBeInvalid();
    expect(dialog.getByLabelText("Name")).toHaveAccessibleDescription("Give the behaviour a name.");
    expect(sent()).toBeUndefined();
  });

  it("needs only a name and a description", async () => {
    const { dialog, router, sent } = await open(() => behaviour({ id: 9 }));
    await userEvent.type(dialog.getByLabelText("Name"), "Stay on the left");
    await userEvent.type(dialog.getByLabelText("Description"), "Never cross the middle.");
    await userEvent.click(dialog.getByRole("button", { name: "Create behaviour" }));
    await screen.findByText("Another page");
    expect(router.state.location.pathname).toBe("/behaviours/9/play");
    expect(sent()).toEqual({
      name: "Stay on the left",
      description: "Never cross the middle.",
      target: null,
      ordered: false,
      game: "space_invaders",
      settings: { max_steps: null, end_rule: null, options: {}, hidden: null },
      measures: [],
    });
  });

  it("takes its target and order from the keyboard as from the mouse", async () => {
    const { dialog, sent } = await open(() => behaviour());
    await userEvent.type(dialog.getByLabelText("Name"), "Three");
    await userEvent.click(await dialog.findByLabelText("Target certain aliens"));
    await userEvent.click(dialog.getByLabelText("The order matters"));
    await userEvent.click(await dialog.findByRole("button", { name: "Alien in row 2, column 1" }));
    await userEvent.keyboard("{ArrowRight} {ArrowDown}{Enter}");
    expect(
      dialog.getByRole("button", { pressed: true, name: /row 1, column 2, 3rd/ }),
    ).toHaveFocus();
    expect(dialog.getByText("3 aliens chosen")).toBeVisible();
    await userEvent.click(dialog.getByRole("button", { name: "Create behaviour" }));
    expect(sent()).toMatchObject({
      target: [
        [1, 0],
        [1, 1],
        [0, 1],
      ],
      ordered: true,
    });
  });

  it("picks whole lines", async () => {
    const { dialog } = await open(() => behaviour());
    await userEvent.click(await dialog.findByLabelText("Target certain aliens"));
    await userEvent.click(await dialog.findByRole("button", { name: "All of column 5" }));
    expect(dialog.getByText("6 aliens chosen")).toBeVisible();
    await userEvent.click(dialog.getByRole("button", { name: "Clear" }));
    expect(dialog.getByText("0 aliens chosen")).toBeVisible();
  });

  it("says why the server refuses it", async () => {
    const refusal = new Refusal(409, { detail: "There are 500 behaviours already." });
    const { dialog } = await open(() => refusal);
    await userEvent.type(dialog.getByLabelText("Name"), "One more");
    await userEvent.click(dialog.getByRole("button", { name: "Create behaviour" }));
    expect(await dialog.findByRole("alert")).toHaveTextContent("500 behaviours already");
  });
});
