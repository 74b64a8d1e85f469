import { screen } from "@testing-library/react";
import { describe, expect, it } from "vitest";

import { BehaviourFrame } from "@/features/behaviours/BehaviourFrame";

import { behaviour } from "../../support/data";
import { show } from "../../support/page";
import { Refusal, serve } from "../../support/server";

const WHY = "There is no Gymnasium environment 'Gone-v0' here.";

function open(status: number) {
  const lost = behaviour({ id: 8, name: "Mine", game: "gym:Gone-v0" });
  serve({
    "GET /api/behaviours": () => [lost],
    "GET /api/behaviours/8": () => lost,
    "GET /api/catalogue/games/gym%3AGone-v0": () =>
      new Refusal(status, { detail: WHY, errors: null }),
    "GET /api/player": () => ({ id: 1, name: "Ada", role: "owner" }),
    "GET /api/behaviours/8/runs": () => [],
  });
  show(<BehaviourFrame behaviourId={8}>{() => <p>Its recordings</p>}</BehaviourFrame>);
}

describe("a behaviour whose game is gone", () => {
  it.each([404, 422])("says so in place of its pages, answered %j", async (status) => {
    open(status);
    expect(await screen.findByRole("heading", { name: "Mine" })).toBeVisible();
    expect(screen.getByText(/Its game gym:Gone-v0 is not installed here/)).toBeVisible();
    expect(screen.getByText(WHY)).toBeVisible();
    expect(screen.getByRole("link", { name: "All behaviours" })).toBeVisible();
    expect(screen.queryByText("Its recordings")).toBeNull();
  });
});
