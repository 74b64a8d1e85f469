import type { QueryClient } from "@tanstack/react-query";

import { behaviourQuery, behavioursQuery } from "@/api/behaviours";
import { libraryQuery } from "@/api/library";
import { playerQuery } from "@/api/system";
import { recordingQuery } from "@/api/recordings";
import { resultsQuery, runQuery } from "@/api/runs";
import { metricsQuery } from "@/features/results/curves/metrics";
import { catalogueQuery, gameQuery } from "@/games/catalogue";

import * as pages from "./pages";

/** The longest time that the first rendering waits for what it shows. */
const PATIENCE_MS = 500;

type Load = (client: QueryClient, id: string) => readonly Promise<unknown>[];

/** Fetches a behaviour and then its game, without which its pages show nothing. */
async function fetchBehaviour(client: QueryClient, id: number): Promise<void> {
  const { game } = await client.query(behaviourQuery(id));
  await client.query(gameQuery(game));
}

const inBehaviour =
  (page: { load: () => Promise<unknown> }, furtherLoads: Load = () => []): Load =>
  (client, id) => [
    page.load(),
    fetchBehaviour(client, Number(id)),
    client.query(behavioursQuery),
    ...furtherLoads(client, id),
  ];

/** By the same paths as in preloads.json. */
export const LOADS: Readonly<Record<string, Load>> = {
  "/": (client) => [
    pages.HomePage.load(),
    client.query(behavioursQuery),
    client.query(catalogueQuery),
  ],
  "/behaviours/([0-9]+)/play": inBehaviour(pages.PlayPage),
  "/behaviours/([0-9]+)/recordings": inBehaviour(pages.RecordingsPage, (client, id) => [
    client.query(libraryQuery(Number(id))),
  ]),
  // Its frame comes first: with the board it would be one long task.
  "/behaviours/([0-9]+)/rank": inBehaviour(pages.RankPage),
  "/behaviours/([0-9]+)/train": inBehaviour(pages.TrainPage),
  "/behaviours/([0-9]+)/runs": inBehaviour(pages.RunsPage),
  "/runs/([0-9a-f-]{36})": (client, id) => [
    pages.RunPage.load(),
    client.query(runQuery(id)).then((run) => fetchBehaviour(client, run.behaviour_id)),
    client.query(resultsQuery(id)),
    client.query(metricsQuery(client, id)),
  ],
  "/recordings/([0-9]+)": (client, id) => [
    pages.RecordingPage.load(),
    client
      .query(recordingQuery(Number(id)))
      .then((recording) => fetchBehaviour(client, recording.behaviour_id)),
  ],
};

/**
 * Loads code and data of the page at an address, all at once. Resolves when they are there, so that
 * the page is rendered once and not for each answer anew; or else after a moment, with what is there.
 */
export async function loadFirstPage(client: QueryClient, path: string): Promise<void> {
  for (const [pattern, load] of Object.entries(LOADS)) {
    const match = new RegExp(`^${pattern}$`).exec(path);
    if (!match) continue;
    const id = match[1] ?? "";
    const patience = new Promise((resolve) => setTimeout(resolve, PATIENCE_MS));
    // The page itself says what failed.
    const all = Promise.allSettled([client.query(playerQuery), ...load(client, id)]);
    await Promise.race([all, patience]);
    return;
  }
}
