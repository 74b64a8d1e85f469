import { fireEvent, screen, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { describe, expect, it } from "vitest";

import type { Behaviour } from "@/api/types";
import { EditBehaviour } from "@/features/behaviours/EditBehaviour";

import { behaviour } from "../../support/data";
import { show } from "../../support/page";
import { Refusal, serve } from "../../support/server";

const MINE: Partial<Behaviour> = { id: 8, name: "Mine", slug: "mine", built_in: false };

async function open(change: Partial<Behaviour>, patch: () => unknown = () => behaviour()) {
  const one = behaviour({ ...MINE, ...change });
  const asked = serve({
    "GET /api/behaviours": () => [behaviour(), one],
    "PATCH /api/behaviours/8": patch,
    "POST /api/behaviours": () => behaviour({ id: 9 }),
    "DELETE /api/behaviours/8": () => undefined,
    "POST /api/behaviours/8/restore": () => one,
  });
  const { router } = show(<EditBehaviour behaviour={one} />);
  await userEvent.click(screen.getByRole("button", { name: "Edit the behaviour" }));
  const dialog = within(await screen.findByRole("dialog", { name: "Edit the behaviour" }));
  const sent = (method: string) => asked.filter((one) => one.method === method);
  return { dialog, router, sent };
}

describe("editing a behaviour", () => {
  it("renames it and changes its target while nothing was played", async () => {
    const { dialog, sent } = await open({});
    await userEvent.clear(dialog.getByLabelText("Name"));
    expect(dialog.getByLabelText("Name")).toBeValid();
    await userEvent.type(dialog.getByLabelText("Name"), "Yours");
    await userEvent.click(await dialog.findByRole("button", { name: "Alien in row 3, column 1" }));
    await userEvent.click(dialog.getByRole("button", { name: "Save" }));
    expect(sent("PATCH")[0]?.body).toEqual({
      name: "Yours",
      description: "Shoot the leftmost column.",
      target: [
        [0, 0],
        [1, 0],
        [2, 0],
      ],
      ordered: false,
      settings: { max_steps: null, end_rule: null, options: {}, hidden: null },
      measures: [],
    });
  });

  it("offers a copy with another target once games were played", async () => {
    const { dialog, router, sent } = await open({ n_recordings: 3 });
    expect(dialog.queryByLabelText("Target certain aliens")).toBeNull();
    await userEvent.click(dialog.getByRole("button", { name: "Make a copy with another target" }));
    const copy = within(screen.getByRole("dialog", { name: "Copy with another target" }));
    expect(copy.getByLabelText("Name")).toHaveValue("Mine with another target");
    await userEvent.click(await copy.findByRole("button", { name: "All of column 2" }));
    await userEvent.click(copy.getByRole("button", { name: "Create behaviour" }));
    await screen.findByText("Another page");
    expect(router.state.location.pathname).toBe("/behaviours/9/play");
    expect(sent("POST")[0]?.body).toMatchObject({ name: "Mine with another target" });
  });

  it("says at the field that a name is taken, and takes it back", async () => {
    const { dialog, sent } = await open({});
    const name = dialog.getByLabelText("Name");
    await userEvent.clear(name);
    await userEvent.type(name, "column 1");
    expect(name).toBeInvalid();
    expect(name).toHaveAccessibleDescription(
      "There is a behaviour named Column 1 already. Choose another name.",
    );
    await userEvent.click(dialog.getByRole("button", { name: "Save" }));
    expect(sent("PATCH")).toEqual([]);
    await userEvent.type(name, "b");
    expect(name).toBeValid();
  });

  it("says at the field that a name is too long, instead of cutting it off", async () => {
    const { dialog, sent } = await open({});
    const name = dialog.getByLabelText("Name");
    fireEvent.change(name, { target: { value: "x".repeat(121) } });
    expect(name).toHaveAccessibleDescription("Use at most 120 characters; these are 121.");
    await userEvent.click(dialog.getByRole("button", { name: "Save" }));
    expect(sent("PATCH")).toEqual([]);
    fireEvent.change(name, { target: { value: "x".repeat(120) } });
    expect(name).toBeValid();
  });

  it("shows at the field what the server says of it", async () => {
    const said = "There is a behaviour named Other already. Choose another name.";
    const refusal = { detail: said, errors: [{ where: ["body", "name"], what: said }] };
    const { dialog } = await open({}, () => new Refusal(409, refusal));
    const name = dialog.getByLabelText("Name");
    await userEvent.clear(name);
    await userEvent.type(name, "Other");
    await userEvent.click(dialog.getByRole("button", { name: "Save" }));
    expect(await dialog.findByText(said)).toBeVisible();
    expect(name).toHaveAccessibleDescription(said);
    await userEvent.type(name, "s");
    expect(name).toBeValid();
  });

  it("deletes it and brings it back", async () => {
    const { dialog, router, sent } = await open({ n_recordings: 3 });
    await userEvent.click(dialog.getByRole("button", { name: "Delete" }));
    await screen.findByText("Mine deleted.");
    expect(router.state.location.pathname).toBe("/");
    expect(sent("DELETE")).toHaveLength(1);
    await userEvent.click(screen.getByRole("button", { name: "Undo" }));
    expect(sent("POST").map(({ path }) => path)).toEqual(["/api/behaviours/8/restore"]);
  });

  it("deletes no built-in one", async () => {
    const { dialog } = await open({ built_in: true });
    expect(dialog.queryByRole("button", { name: "Delete" })).toBeNull();
  });
});
