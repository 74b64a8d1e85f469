import { queryOptions } from "@tanstack/react-query";

import { api, patientFetch, ProblemError, unwrap } from "@/api/client";
import type { Ranking, Recording } from "@/api/types";

import type { Tiers } from "./order";

function at(behaviourId: number) {
  return { params: { path: { behaviour_id: behaviourId } } };
}

export function rankingQuery(behaviourId: number) {
  return queryOptions({
    queryKey: ["ranking", behaviourId],
    queryFn: ({ signal }) =>
      unwrap(api.GET("/api/behaviours/{behaviour_id}/ranking", { ...at(behaviourId), signal })),
  });
}

const N_VARIED_GAMES = 24;

/** Adds games of other behaviours and of varied play, unranked; takes seconds. */
export function addVariedGames(behaviourId: number): Promise<Recording[]> {
  return unwrap(
    api.POST("/api/behaviours/{behaviour_id}/borrowed", {
      ...at(behaviourId),
      body: { count: N_VARIED_GAMES },
      fetch: patientFetch,
    }),
  );
}

/**
 * Saves an order based on a revision.
 *
 * @throws {RankingConflictError} The revision is outdated.
 */
export async function saveRanking(
  behaviourId: number,
  baseRevision: number,
  tiers: Tiers,
): Promise<Ranking> {
  try {
    return await unwrap(
      api.PUT("/api/behaviours/{behaviour_id}/ranking", {
        ...at(behaviourId),
        body: { base_revision: baseRevision, tiers: tiers.map((tier) => [...tier]) },
      }),
    );
  } catch (error) {
    throw conflictOf(error) ?? error;
  }
}

/** Undoes or redoes the last change. */
export async function stepRanking(
  behaviourId: number,
  baseRevision: number,
  step: "undo" | "redo",
): Promise<Ranking> {
  try {
    return await unwrap(
      api.POST(`/api/behaviours/{behaviour_id}/ranking/${step}`, {
        ...at(behaviourId),
        body: { base_revision: baseRevision },
      }),
    );
  } catch (error) {
    throw conflictOf(error) ?? error;
  }
}

/** Another tab or person saved first. */
export class RankingConflictError extends Error {
  override name = "RankingConflictError";
  readonly current: Ranking;

  constructor(message: string, current: Ranking) {
    super(message);
    this.current = current;
  }
}

function conflictOf(error: unknown): RankingConflictError | null {
  if (!(error instanceof ProblemError) || error.status !== 409) return null;
  const body = error.body;
  if (typeof body !== "object" || body === null || !("current" in body)) return null;
  return new RankingConflictError(error.message, body.current as Ranking);
}
