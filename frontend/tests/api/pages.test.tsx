import { QueryClient } from "@tanstack/react-query";
import { describe, expect, it } from "vitest";

import { PAGE_LENGTH } from "@/api/batches";
import { behavioursQuery } from "@/api/behaviours";
import { browsersQuery, invitationsQuery, peopleQuery } from "@/api/people";
import { activeRunsQuery, runsQuery } from "@/api/runs";

import { type Asked, serve } from "../support/server";

const ALL = Array.from({ length: 2 * PAGE_LENGTH + 1 }, (_, index) => ({ id: index + 1 }));

/** Answers with what follows the entry that a request names, as the server does. */
function page({ query }: Asked) {
  const last = Number(query.get("after") ?? query.get("before") ?? 0);
  return ALL.slice(last, last + Number(query.get("limit")));
}

describe("a list of more entries than the server returns at once", () => {
  it.each([
    ["/api/behaviours", behavioursQuery, "after"],
    ["/api/people", peopleQuery, "after"],
    ["/api/browsers", browsersQuery, "before"],
    ["/api/invitations", invitationsQuery, "before"],
    ["/api/runs", runsQuery(), "before"],
    ["/api/runs", runsQuery(3), "before"],
    ["/api/runs", activeRunsQuery, "before"],
  ] as const)("%s is fetched page by page", async (path, query, cursor) => {
    const asked = serve({ [`GET ${path}`]: page });
    const client = new QueryClient();
    expect(await client.query(query as typeof peopleQuery)).toEqual(ALL);
    expect(asked.map(({ query: given }) => given.get(cursor))).toEqual([null, "200", "400"]);
  });

  it("keeps its filter on every page", async () => {
    const asked = serve({ "GET /api/runs": page });
    await new QueryClient().query(runsQuery(3));
    expect(asked.map(({ query }) => query.get("behaviour_id"))).toEqual(["3", "3", "3"]);
  });
});
