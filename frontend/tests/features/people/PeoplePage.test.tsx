import { screen, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { describe, expect, it } from "vitest";

import { PeoplePage } from "@/features/people/PeoplePage";

import { behaviour } from "../../support/data";
import { show } from "../../support/page";
import { serve } from "../../support/server";

const browser = (more: object) => ({
  id: 1,
  name: "Firefox on Linux",
  player: "Ada",
  role: "owner",
  created_at: "2026-01-01T10:00:00Z",
  seen_at: null,
  present: true,
  ...more,
});

const PEOPLE = {
  "GET /api/player": () => ({ id: 1, name: "Ada", role: "owner" }),
  "GET /api/behaviours": () => [behaviour({ id: 1, name: "Column 1" })],
  "GET /api/people": () => [
    { id: 1, name: "Ada", role: "owner", behaviour_ids: [] },
    { id: 2, name: "Ben", role: "participant", behaviour_ids: [1] },
  ],
  "GET /api/browsers": () => [
    browser({}),
    browser({
      id: 2,
      name: "Safari on iPhone",
      player: "Ben",
      role: "participant",
      present: false,
    }),
  ],
  "GET /api/invitations": () => [],
  "GET /api/keys": () => [],
  "GET /api/audit": () => [
    {
      id: 4,
      at: "2026-01-01T10:00:00Z",
      player: "Ben",
      action: "signed in",
      subject: "browser 2",
      details: {},
    },
  ],
};

describe("the page of people", () => {
  it("lists browsers and signs another one out", async () => {
    const ended: string[] = [];
    serve({
      ...PEOPLE,
      "DELETE /api/browsers/2": () => {
        ended.push("2");
        return undefined;
      },
    });
    show(<PeoplePage />);
    expect(await screen.findByText("This browser")).toBeVisible();
    expect(await screen.findByText(/signed in \(browser 2\)/)).toBeVisible();
    await userEvent.click(screen.getByRole("button", { name: "Sign out Ben, Safari on iPhone" }));
    await expect.poll(() => ended).toEqual(["2"]);
  });

  it("says in words who did what, and shows an unknown action as it is stored", async () => {
    const entry = (id: number, action: string, subject: string, details: object = {}) => ({
      id,
      at: "2026-01-01T10:00:00Z",
      player: "Ada",
      action,
      subject,
      details,
    });
    serve({
      ...PEOPLE,
      "GET /api/audit": () => [
        entry(7, "deleted", "recording 163", { number: 4, behaviour: 1 }),
        entry(6, "queued a run", "run 3f2a9c41-0000", { behaviour: 1, recipe: "standard" }),
        entry(5, "ranked", "behaviour 1", { revision: 4, change: "edit" }),
        entry(4, "ranked", "behaviour 1", { revision: 3, change: "undo" }),
        entry(3, "changed a role", "player 2", {
          name: "Ben",
          before: "participant",
          role: "researcher",
        }),
        entry(2, "imported", "behaviour 1", { recordings: 1 }),
        entry(1, "measured", "thing 7", { size: 3 }),
      ],
    });
    show(<PeoplePage />);
    const log = within(await screen.findByRole("region", { name: "Log" }));
    await expect
      .poll(() => log.getAllByRole("listitem").map((item) => item.textContent.split("Ada ")[1]))
      .toEqual([
        "deleted recording 4 (behaviour 1)",
        "started Run 3f2a9c (behaviour 1, recipe: standard)",
        "ranked behaviour 1 (revision 4)",
        "ranked behaviour 1 (revision 3, undone)",
        "changed what person 2 may do (Ben, before: Player, role: Researcher)",
        "imported behaviour 1 (1 recording)",
        "measured thing 7 (size: 3)",
      ]);
  });

  it("makes a link for players of a behaviour and shows it once", async () => {
    const wishes: unknown[] = [];
    serve({
      ...PEOPLE,
      "POST /api/invitations": ({ body }) => {
        wishes.push(body);
        return {
          id: 1,
          name: "5b",
          role: "participant",
          behaviour_id: 1,
          created_at: "2026-01-01T10:00:00Z",
          n_used: 0,
          max_uses: 24,
          expires_at: "2026-01-08T10:00:00Z",
          path: "/join?invitation=abc",
        };
      },
    });
    show(<PeoplePage />);
    await userEvent.type(await screen.findByLabelText("Who is invited"), "5b");
    await userEvent.selectOptions(screen.getByLabelText("What they may do"), "Play Column 1");
    expect(screen.getByLabelText("People it lets in")).toHaveValue(30);
    await userEvent.clear(screen.getByLabelText("People it lets in"));
    await userEvent.type(screen.getByLabelText("People it lets in"), "24");
    await userEvent.clear(screen.getByLabelText("Days it is valid"));
    await userEvent.type(screen.getByLabelText("Days it is valid"), "7");
    await userEvent.click(screen.getByRole("button", { name: "Make a link" }));
    expect(await screen.findByText(/\/join\?invitation=abc$/)).toBeVisible();
    expect(wishes).toEqual([
      { name: "5b", role: "participant", behaviour_id: 1, max_uses: 24, days: 7 },
    ]);
  });

  it("says how often an invitation was used and how long it is valid", async () => {
    const invitation = {
      role: "participant",
      behaviour_id: 1,
      created_at: "2026-01-01T10:00:00Z",
      n_used: 3,
    };
    serve({
      ...PEOPLE,
      "GET /api/invitations": () => [
        { ...invitation, id: 2, name: "5b", max_uses: 30, expires_at: "2026-01-31T10:00:00Z" },
        { ...invitation, id: 1, name: "of old", max_uses: null, expires_at: null },
      ],
    });
    show(<PeoplePage />);
    expect(await screen.findByText(/used 3 times of 30, until /)).toBeVisible();
    expect(screen.getByText(/used 3 times$/)).toBeVisible();
  });

  it("makes a key that starts workers and does nothing else", async () => {
    const wishes: unknown[] = [];
    serve({
      ...PEOPLE,
      "POST /api/keys": ({ body }) => {
        wishes.push(body);
        return {
          id: 1,
          name: "Lab",
          player: "Ada",
          role: "worker",
          created_at: "2026-01-01T10:00:00Z",
          seen_at: null,
          key: "secret.signature",
        };
      },
    });
    show(<PeoplePage />);
    await userEvent.type(await screen.findByLabelText("What the key is for"), "Lab");
    await userEvent.selectOptions(
      screen.getByLabelText("What it may do"),
      "Start workers on other machines, and nothing else",
    );
    await userEvent.click(screen.getByRole("button", { name: "Make a key" }));
    expect(await screen.findByText("secret.signature")).toBeVisible();
    expect(wishes).toEqual([{ name: "Lab", role: "worker" }]);
  });

  it("makes a player a researcher, and offers no change of the owner", async () => {
    const wishes: unknown[] = [];
    serve({
      ...PEOPLE,
      "PUT /api/people/2/role": ({ body }) => {
        wishes.push(body);
        return undefined;
      },
    });
    show(<PeoplePage />);
    const select = await screen.findByLabelText("What Ben may do");
    expect(await screen.findByRole("option", { name: "Plays Column 1" })).toBeInTheDocument();
    expect(screen.getByRole("button", { name: "Change what Ben may do" })).toBeDisabled();
    await userEvent.selectOptions(select, "Everything but this page, as researchers");
    await userEvent.click(screen.getByRole("button", { name: "Change what Ben may do" }));
    await expect.poll(() => wishes).toEqual([{ role: "researcher" }]);
    expect(screen.queryByLabelText("What Ada may do")).toBeNull();
  });

  it("is for the owner only", async () => {
    serve({ ...PEOPLE, "GET /api/player": () => ({ id: 2, name: "Ria", role: "researcher" }) });
    show(<PeoplePage />);
    expect(await screen.findByText("Only the owner sees this page")).toBeVisible();
  });
});
