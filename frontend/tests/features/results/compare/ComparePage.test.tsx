import { screen, within } from "@testing-library/react";
import { expect, it, vi } from "vitest";

import { ComparePage } from "@/features/results/compare/ComparePage";

import { behaviour, run } from "../../../support/data";
import { show } from "../../../support/page";
import { serve } from "../../../support/server";

// Charts need a canvas, which jsdom lacks; the browser tests cover them.
vi.mock("@/features/results/curves/Chart", () => ({
  Chart: ({ title, isNamed }: { title: string; isNamed?: boolean }) => (
    <figure aria-label={title} data-named={isNamed} />
  ),
}));

it("runs are compared as far as they can be loaded", async () => {
  const runs = [run({ id: "a", name: "Wide" }), run({ id: "b", steps: 500_000 })];
  const metrics = { last: 1, series: { imitator: { entropy: [[1, 2]] } } };
  serve({
    ...Object.fromEntries(runs.map((one) => [`GET /api/runs/${one.id}`, () => one])),
    ...Object.fromEntries(runs.map(({ id }) => [`GET /api/runs/${id}/metrics`, () => metrics])),
    "GET /api/behaviours/1": () => behaviour(),
  });
  show(<ComparePage />, "/?run=a&run=b&run=gone");
  expect(await screen.findByRole("heading", { name: "2 runs compared" })).toBeVisible();
  expect(screen.getByText(/1 run could not be loaded/)).toBeVisible();
  const table = within(screen.getByRole("table", { name: "Runs side by side" }));
  expect(table.getByRole("columnheader", { name: /Wide/ })).toBeVisible();
  expect(table.getByRole("row", { name: "steps 20,000 500,000" })).toBeVisible();
  const chart = await screen.findByRole("figure", { name: "Indecision (entropy)" });
  expect(chart).toBeVisible();
  expect(chart).toHaveAttribute("data-named", "true");
  expect(screen.getByRole("button", { name: "Download the curves (CSV)" })).toBeVisible();
});
