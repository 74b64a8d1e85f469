import { act, fireEvent, screen, waitFor, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { describe, expect, it } from "vitest";

import type { Behaviour } from "@/api/types";
import { writeDraft } from "@/lib/browser/drafts";
import { TrainPage } from "@/features/training/TrainPage";

import { behaviour, recipe, run, system } from "../../support/data";
import { show } from "../../support/page";
import { Refusal, serve } from "../../support/server";

const RANKED = behaviour({ n_recordings: 3, n_ranked: 3, n_perfect: 1 });

function open(one: Behaviour, answers: Parameters<typeof serve>[0] = {}, path = "/") {
  const asked = serve({
    "GET /api/recipes": () => [recipe(), recipe({ name: "paper", default_steps: 10_000_000 })],
    "GET /api/system": () => system(true),
    ...answers,
  });
  return { asked, ...show(<TrainPage behaviour={one} />, path) };
}

describe("training", () => {
  it("says what is missing and can't be started", async () => {
    open(behaviour({ n_recordings: 3 }));
    expect(await screen.findByText(/Rank at least two games/)).toBeVisible();
    expect(screen.getByRole("button", { name: "Train" })).toBeDisabled();
  });

  it("says that the best ranked stand in where none is marked as perfect", async () => {
    open({ ...RANKED, n_perfect: 0 });
    expect(await screen.findByText(/the clone copies the best ranked ones/)).toBeVisible();
    expect(screen.getByRole("button", { name: "Train" })).toBeEnabled();
  });

  it("says that fast knows aliens alone where a behaviour may be about something else", async () => {
    open(
      { ...RANKED, target: null },
      { "GET /api/recipes": () => [recipe({ name: "any" }), recipe()] },
    );
    await userEvent.click(await screen.findByRole("radio", { name: /fast/ }));
    expect(screen.getByText(/considers only what is hit/)).toHaveTextContent(
      "take the recipe any.",
    );
    await userEvent.click(screen.getByRole("radio", { name: /any/ }));
    expect(screen.queryByText(/considers only what is hit/)).toBeNull();
  });

  it("says that the recipe of an address is no longer there", async () => {
    open(RANKED, {}, "/?recipe=dagger");
    expect(await screen.findByText(/has no recipe/)).toHaveTextContent(
      "This version of Tril has no recipe dagger for this game. fast is chosen instead.",
    );
    expect(screen.getByRole("radio", { name: /fast/ })).toBeChecked();
  });

  it("recommends the proposed recipe alone", async () => {
    open(
      { ...RANKED, target: null },
      { "GET /api/recipes": () => [recipe({ name: "any" }), recipe()] },
    );
    expect(await screen.findByRole("radio", { name: /any\s*Recommended/ })).toBeChecked();
    expect(screen.getByRole("radio", { name: /fast/ })).not.toHaveAccessibleName(/Recommended/);
  });

  it("describes a recipe in plain words, with the time that it takes on this machine", async () => {
    const stranger = recipe({ name: "lab", summary: "Our own values." });
    open(RANKED, { "GET /api/recipes": () => [recipe(), recipe({ name: "any" }), stranger] });
    const fast = await screen.findByRole("radio", { name: "fast Recommended" });
    expect(fast).toHaveAccessibleDescription(
      "Take it if your order is about what gets hit." +
        " Needs: at least two ranked games; stars on the best ones help." +
        " Takes: about 12\u00a0min." +
        " Gives: an imitator that starts from a copy of your best games, and what should be hit.",
    );
    expect(screen.getByRole("radio", { name: "any" })).toHaveAccessibleDescription(
      /^Take it for any goal, in any game\./,
    );
    expect(screen.getByRole("radio", { name: "lab" })).toHaveAccessibleDescription(
      "Our own values. Takes: about 12\u00a0min.",
    );
  });

  it("keeps what was entered when the page is left, and warns of an order that is not saved", async () => {
    writeDraft("ranking 1", { base: 1, tiers: [[1], [2]] });
    const { router } = open(RANKED);
    await userEvent.click(await screen.findByRole("radio", { name: /paper/ }));
    const steps = () => screen.getByLabelText(/^Steps/);
    await userEvent.clear(steps());
    await userEvent.type(steps(), "1234");
    expect(screen.getByText(/Your last order is not saved yet/)).toBeVisible();
    await act(() => router.navigate("/elsewhere"));
    await screen.findByText("Another page");
    await act(() => router.navigate("/"));
    expect(await screen.findByRole("radio", { name: /paper/ })).toBeChecked();
    expect(steps()).toHaveValue("1234");
  });

  it("offers to go on anyway only where the check may stop the run", async () => {
    open(RANKED, {
      "GET /api/recipes": () => [recipe(), recipe({ name: "gail", values: { method: "gail" } })],
    });
    expect(await screen.findByLabelText("Go on anyway")).toBeInTheDocument();
    await userEvent.click(screen.getByRole("radio", { name: /gail/ }));
    expect(screen.queryByLabelText("Go on anyway")).toBeNull();
  });

  it("works on the scripted example where nothing was played", async () => {
    const { asked, router } = open(behaviour(), {
      "POST /api/runs": () => run({ id: "r3", status: "queued", example: true }),
    });
    expect(await screen.findByText(/a scripted player, not a person/)).toBeVisible();
    await userEvent.click(screen.getByRole("button", { name: "Train on the example" }));
    await waitFor(() => expect(router.state.location.pathname).toBe("/runs/r3"));
    expect(asked.find(({ method }) => method === "POST")?.body).toMatchObject({ example: true });
  });

  it("starts with what was chosen, and says why it is refused", async () => {
    let refused = true;
    const { asked, router } = open(RANKED, {
      "POST /api/runs": () =>
        refused
          ? new Refusal(422, { detail: "Recording 4 isn't verified." })
          : run({ id: "r2", status: "queued" }),
    });
    await userEvent.click(await screen.findByRole("radio", { name: /paper/ }));
    expect(screen.getByLabelText("Steps")).toHaveValue("10,000,000");
    await userEvent.click(screen.getByRole("button", { name: "20\u00a0k" }));
    await userEvent.click(screen.getByText("More settings"));
    await userEvent.clear(screen.getByLabelText("Training seed"));
    await userEvent.type(screen.getByLabelText("Training seed"), "7");
    await userEvent.click(screen.getByLabelText("Only on a GPU"));
    await userEvent.click(screen.getByRole("button", { name: "Train" }));
    expect(await screen.findByRole("alert")).toHaveTextContent("Recording 4 isn't verified.");
    refused = false;
    await userEvent.click(screen.getByRole("button", { name: "Train" }));
    await waitFor(() => expect(router.state.location.pathname).toBe("/runs/r2"));
    expect(asked.filter(({ method }) => method === "POST").at(-1)?.body).toMatchObject({
      recipe: "paper",
      steps: 20_000,
      training_seed: 7,
      go_on_anyway: false,
      device: "gpu",
      example: false,
    });
  });

  it("proposes more steps where aliens are to be hit in order, beside presets far enough from it", async () => {
    open(
      { ...RANKED, ordered: true },
      { "GET /api/recipes": () => [recipe({ ordered_steps: 1_800_000 })] },
    );
    expect(await screen.findByLabelText("Steps")).toHaveValue("1,800,000");
    const presets = within(screen.getByRole("group", { name: "Preset numbers of steps" }));
    expect(presets.getAllByRole("button").map((button) => button.textContent)).toEqual([
      "20\u00a0k",
      "200\u00a0k",
      "1.8\u00a0M",
      "10\u00a0M",
    ]);
  });

  it("says when so few steps teach nothing", async () => {
    open(RANKED);
    const steps = await screen.findByLabelText("Steps");
    expect(screen.queryByText(/^Too short/)).toBeNull();
    fireEvent.change(steps, { target: { value: "12,000" } });
    expect(screen.getByText(/^Too short: for the first 12,000/)).toBeVisible();
    fireEvent.change(steps, { target: { value: "12,001" } });
    expect(screen.queryByText(/^Too short/)).toBeNull();
  });

  it("keeps what was typed when another recipe is chosen; the rest follows the recipe", async () => {
    open(RANKED);
    await userEvent.click(await screen.findByText("More settings"));
    const seed = screen.getByLabelText("Training seed");
    await userEvent.clear(seed);
    await userEvent.type(seed, "7");
    await userEvent.click(screen.getByRole("radio", { name: /paper/ }));
    expect(seed).toHaveValue("7");
    expect(screen.getByLabelText("Steps")).toHaveValue("10,000,000");
    await userEvent.click(screen.getByRole("button", { name: "20\u00a0k" }));
    await userEvent.click(screen.getByRole("radio", { name: /fast/ }));
    expect(screen.getByLabelText("Steps")).toHaveValue("20,000");
    expect(seed).toHaveValue("7");
  });

  it("continues the run that the address names, unless it is removed", async () => {
    const parent = "3f2a9c00-0000-4000-8000-000000000000";
    const answers = { "POST /api/runs": () => new Refusal(409, { detail: "It is gone." }) };
    const { asked, router } = open(RANKED, answers, `/?continue=${parent}`);
    const link = await screen.findByRole("link", { name: "Run 3f2a9c" });
    expect(link).toHaveAttribute("href", `/runs/${parent}`);
    await userEvent.click(screen.getByRole("button", { name: "Train" }));
    expect(await screen.findByRole("alert")).toHaveTextContent("It is gone.");
    await userEvent.click(screen.getByRole("button", { name: "Begin with the clone" }));
    expect(link).not.toBeInTheDocument();
    expect(router.state.location.search).toBe("");
    await userEvent.click(screen.getByRole("button", { name: "Train" }));
    const sent = () => asked.filter(({ method }) => method === "POST").map(({ body }) => body);
    await waitFor(() => expect(sent()).toHaveLength(2));
    expect(sent()).toMatchObject([{ parent_run_id: parent }, { parent_run_id: null }]);
  });

  it("takes the place of a run that still trains, with the steps that are left", async () => {
    const parent = run({ id: "3f2a9c00-0000-4000-8000-000000000000", status: "running" });
    const answers = {
      [`GET /api/runs/${parent.id}`]: () => parent,
      "POST /api/runs": () => new Refusal(409, { detail: "It is gone." }),
    };
    const { asked } = open(RANKED, answers, `/?continue=${parent.id}&steps=200000`);
    expect(await screen.findByLabelText("Steps")).toHaveValue("200,000");
    expect(await screen.findByText(/it is cancelled when this one starts/)).toBeVisible();
    await userEvent.click(screen.getByRole("button", { name: "Train" }));
    const sent = () => asked.find(({ method }) => method === "POST")?.body;
    await waitFor(() =>
      expect(sent()).toMatchObject({
        parent_run_id: parent.id,
        cancel_parent: true,
        steps: 200_000,
      }),
    );
  });

  it("begins with the settings of a run that is made again", async () => {
    const { asked } = open(
      RANKED,
      { "POST /api/runs": () => run({ id: "r4", status: "queued" }) },
      "/?recipe=paper&steps=500000&seed=3&rate=0.001&anyway=1",
    );
    expect(await screen.findByRole("radio", { name: /paper/ })).toBeChecked();
    expect(screen.getByLabelText("Steps")).toHaveValue("500,000");
    expect(screen.getByLabelText("Training seed")).toBeVisible();
    await userEvent.click(screen.getByRole("button", { name: "Train" }));
    await waitFor(() => expect(asked.some(({ method }) => method === "POST")).toBe(true));
    expect(asked.find(({ method }) => method === "POST")?.body).toMatchObject({
      recipe: "paper",
      steps: 500_000,
      training_seed: 3,
      learning_rate: 0.001,
      go_on_anyway: true,
      device: "any",
    });
  });

  it("names a number that won't do", async () => {
    open(RANKED);
    const steps = await screen.findByLabelText("Steps");
    await userEvent.clear(steps);
    await userEvent.type(steps, "lots");
    expect(steps).toBeInvalid();
    expect(steps).toHaveAccessibleDescription(/whole number of steps/);
    await userEvent.click(screen.getByRole("button", { name: "Train" }));
    expect(steps).toHaveFocus();
    await userEvent.clear(steps);
    await userEvent.type(steps, "99999999999");
    expect(steps).toBeInvalid();
    expect(screen.queryByText(/on this machine/)).toBeNull();
    await userEvent.clear(steps);
    await userEvent.type(steps, "300");
    expect(steps).toBeValid();
    expect(screen.getByText(/on this machine/)).toBeVisible();
  });
});
