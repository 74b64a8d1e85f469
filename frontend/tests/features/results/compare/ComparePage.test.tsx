import { screen, within } from "@testing-library/react";
import { expect, it } from "vitest";

import { ComparePage } from "@/features/results/compare/ComparePage";

import { behaviour, run } from "../../../support/data";
import { show } from "../../../support/page";
import { serve } from "../../../support/server";

it("runs are compared as far as they can be loaded", async () => {
  const runs = [run({ id: "a", name: "Wide" }), run({ id: "b", steps: 500_000 })];
  const curves = { imitator: { entropy: [[1, 2]] } };
  serve({
    ...Object.fromEntries(runs.map((one) => [`GET /api/runs/${one.id}`, () => one])),
    "GET /api/runs/a/metrics": () => ({ last: 1, series: curves }),
    "GET /api/runs/b/metrics": () => ({ last: 0, series: {} }),
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
  expect(await within(chart).findByText("Wide")).toBeVisible(); // the only line, named all the same
  expect(screen.getByRole("button", { name: "Download the curves (CSV)" })).toBeVisible();
});
