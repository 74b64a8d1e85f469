import { screen, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { describe, expect, it, vi } from "vitest";

import { RunsPage } from "@/features/results/RunsPage";

import { behaviour, headline, run } from "../../support/data";
import { show } from "../../support/page";
import { serve } from "../../support/server";

const RUNS = [
  run({ id: "aaaaaa00", name: "Wide network", notes: "Twice as wide.", status: "done" }),
  run({ id: "bbbbbb00", recipe: "paper", status: "queued", queue_position: 2 }),
];

function open(path = "/") {
  serve({ "GET /api/runs": () => RUNS });
  return show(<RunsPage behaviour={behaviour()} />, path);
}

function shownRuns(): (string | null)[] {
  const table = within(screen.getByRole("table", { name: "Runs" }));
  return table.getAllByRole("rowheader").map((cell) => within(cell).getByRole("link").textContent);
}

describe("the list of runs", () => {
  it("shows names, notes and the place in the queue", async () => {
    open();
    const named = await screen.findByRole("row", { name: /Wide network/ });
    expect(named).toHaveTextContent("Wide networkRun aaaaaaTwice as wide.");
    expect(screen.getByRole("row", { name: /Run bbbbbb/ })).toHaveTextContent(
      "Waitingnumber 2 in the queue",
    );
  });

  it("has the state under the name on a phone", async () => {
    vi.stubGlobal("matchMedia", (query: string) =>
      Object.assign(new EventTarget(), { media: query, matches: query === "(max-width: 34rem)" }),
    );
    open();
    const named = await screen.findByRole("rowheader", { name: /Wide network/ });
    expect(named).toHaveTextContent(/^Wide networkDone/);
    expect(screen.getByRole("rowheader", { name: /Run bbbbbb/ })).toHaveTextContent(
      "Waitingnumber 2 in the queue",
    );
    expect(screen.queryByRole("columnheader", { name: "State" })).toBeNull();
    vi.unstubAllGlobals();
  });

  it("says how much of what was understood is played where there are no targets", async () => {
    const share = { mean: 0.876, low: 0.81, high: 0.92, n: 23 };
    const understood = { imitator: share, clone: null, best: share, read: null };
    serve({
      "GET /api/runs": () => [run({ status: "done", headline: headline({ understood }) })],
    });
    show(<RunsPage behaviour={behaviour({ target: null })} />);
    expect(await screen.findByRole("columnheader", { name: "Worth" })).toBeVisible();
    expect(screen.getByRole("cell", { name: /^88%81% to 92%/ })).toBeVisible();
  });

  it("is searched and filtered, and the address keeps it", async () => {
    const { router } = open();
    await userEvent.type(await screen.findByRole("searchbox"), "twice");
    expect(shownRuns()).toEqual(["Wide network"]);
    expect(screen.getByRole("heading", { name: "1 of 2 runs" })).toBeVisible();
    expect(router.state.location.search).toBe("?q=twice");
    await userEvent.click(screen.getByRole("button", { name: "Clear the filters" }));
    await userEvent.selectOptions(screen.getByLabelText("Recipe"), "paper");
    expect(shownRuns()).toEqual(["Run bbbbbb"]);
    await userEvent.selectOptions(screen.getByLabelText("State"), "Done");
    expect(screen.getByText(/No run matches the filters/)).toBeVisible();
    await userEvent.click(screen.getByRole("button", { name: "Show all" }));
    expect(shownRuns()).toHaveLength(2);
  });

  it("compares the runs that are ticked", async () => {
    open();
    await userEvent.click(await screen.findByRole("checkbox", { name: "Compare Wide network" }));
    expect(screen.getByText("Tick one more to compare.")).toBeVisible();
    await userEvent.click(screen.getByRole("checkbox", { name: "Compare Run bbbbbb" }));
    expect(screen.getByRole("link", { name: "Compare 2 runs" })).toHaveAttribute(
      "href",
      "/runs/compare?run=aaaaaa00&run=bbbbbb00",
    );
  });

  it("begins as the address says", async () => {
    open("/?state=active&order=name");
    expect(await screen.findByLabelText("Order")).toHaveValue("name");
    expect(shownRuns()).toEqual(["Run bbbbbb"]);
  });
});
