import { expect, it } from "vitest";

import { LOADS, loadFirstPage } from "@/app/first-page";
import { createQueryClient } from "@/app/query-client";
import preloads from "../../preloads.json";
import { serve } from "../support/server";

const RUN = "11111111-2222-4333-8444-555555555555";

it("the same pages are known to the server's preload links", () => {
  expect(preloads.map((one) => one.path)).toEqual(Object.keys(LOADS));
});

it.each([
  ["/runs/compare", []],
  ["/runs/11", []],
  [`/runs/${RUN}`, ["/api/player", `/api/runs/${RUN}`, `/api/runs/${RUN}/results`]],
  ["/recordings/3", ["/api/player", "/api/recordings/3"]],
  ["/nowhere", []],
])("the data of %s is asked for with its code", async (path, expected) => {
  const asked = serve({});
  await loadFirstPage(createQueryClient(), path);
  const paths = asked.map((one) => one.path);
  expect(paths).toEqual(expect.arrayContaining(expected));
  if (!expected.length) expect(paths).toEqual([]);
});
