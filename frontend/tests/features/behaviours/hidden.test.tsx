import { fireEvent, screen, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import fc from "fast-check";
import { describe, expect, it, vi } from "vitest";

import type { Behaviour } from "@/api/types";
import {
  type Area,
  between,
  middle,
  moved,
  resized,
  withEdge,
} from "@/features/behaviours/hidden/areas";
import { HiddenAreasDialog } from "@/features/behaviours/hidden/HiddenAreasDialog";

import { behaviour } from "../../support/data";
import { gameRoutes, PONG } from "../../support/games";
import { show } from "../../support/page";
import { serve } from "../../support/server";

const SCREEN = { width: 160, height: 210 };

function isWithin([left, top, right, bottom]: Area): boolean {
  return (
    left >= 0 &&
    left < right &&
    right <= SCREEN.width &&
    top >= 0 &&
    top < bottom &&
    bottom <= SCREEN.height
  );
}

describe("an area", () => {
  const number = fc.integer({ min: -400, max: 400 });
  const point = fc.record({ x: number, y: number });

  it("stays a rectangle within the screen, whatever is done to it", () => {
    fc.assert(
      fc.property(point, point, point, fc.nat(3), number, (one, other, by, edge, value) => {
        const area = between(one, other, SCREEN);
        const all = [
          area,
          moved(area, by, SCREEN),
          resized(area, by, SCREEN),
          withEdge(area, edge, value, SCREEN),
          middle(SCREEN),
        ];
        expect(all.filter((each) => !isWithin(each))).toEqual([]);
      }),
    );
  });

  it("keeps its size when it is moved, and its corner when it is resized", () => {
    expect(moved([10, 20, 30, 40], { x: 500, y: -5 }, SCREEN)).toEqual([140, 15, 160, 35]);
    expect(resized([10, 20, 30, 40], { x: -500, y: 5 }, SCREEN)).toEqual([10, 20, 11, 45]);
  });
});

function open(change: Partial<Behaviour> = {}, game = PONG) {
  const one = behaviour({ id: 8, built_in: false, game: game.name, target: null, ...change });
  const asked = serve({
    ...gameRoutes(game),
    "PATCH /api/behaviours/8": () => one,
    "GET /api/behaviours": () => [one],
  });
  const closed = vi.fn();
  show(<HiddenAreasDialog behaviour={one} onClose={closed} />, "/", game);
  const sent = () => asked.find(({ method }) => method === "PATCH")?.body;
  return { sent, closed };
}

const areas = () => screen.queryAllByRole("button", { name: /^Area \d/ });

describe("what learning sees", () => {
  it("covers what the game proposes, and what is added, moved and typed", async () => {
    const { sent, closed } = open();
    expect(areas()).toHaveLength(1);
    await userEvent.click(screen.getByRole("button", { name: "Cover another area" }));
    const second = screen.getByRole("button", { name: "Area 2: from 70, 95 to 90, 115" });
    second.focus();
    await userEvent.keyboard("{ArrowLeft}{ArrowDown}{Shift>}{ArrowRight}{/Shift}");
    const fields = within(screen.getByRole("group", { name: "Area 2" }));
    expect(fields.getAllByRole("spinbutton").map((one) => (one as HTMLInputElement).value)).toEqual(
      ["69", "96", "90", "116"],
    );
    fireEvent.change(fields.getByLabelText("Left"), { target: { value: "60" } });
    await userEvent.click(screen.getByRole("button", { name: "Save" }));
    await vi.waitFor(() => expect(closed).toHaveBeenCalled());
    expect(sent()).toEqual({
      settings: {
        options: {},
        hidden: [
          [0, 0, 160, 22],
          [60, 96, 90, 116],
        ],
      },
    });
  });

  it("is drawn by a pointer on the picture", () => {
    open();
    const picture = screen.getByRole("img", { name: /some seconds after its start/ });
    const stage = picture.parentElement;
    if (!stage) throw new Error("The picture stands alone.");
    stage.setPointerCapture = vi.fn();
    vi.spyOn(stage, "getBoundingClientRect").mockReturnValue(new DOMRect(0, 0, 320, 420));
    fireEvent.pointerDown(stage, { button: 0, clientX: 20, clientY: 100, pointerId: 1 });
    fireEvent.pointerMove(stage, { clientX: 60, clientY: 160, pointerId: 1 });
    fireEvent.pointerUp(stage, { pointerId: 1 });
    fireEvent.pointerMove(stage, { clientX: 300, clientY: 400, pointerId: 1 });
    expect(areas()[1]).toHaveAccessibleName("Area 2: from 10, 50 to 30, 80");
  });

  it("goes back to what the game proposes, which is stored as nothing", async () => {
    const { sent } = open();
    areas()[0]?.focus();
    await userEvent.keyboard("{Delete}");
    expect(areas()).toEqual([]);
    expect(screen.getByText("Nothing is covered.")).toBeVisible();
    await userEvent.click(screen.getByRole("button", { name: "As proposed" }));
    expect(areas()).toHaveLength(1);
    await userEvent.click(screen.getByRole("button", { name: "Save" }));
    await vi.waitFor(() => expect(sent()).toEqual({ settings: { options: {}, hidden: null } }));
  });

  it("stays as it is once a run has learned from it", () => {
    open({ n_runs: 1 });
    expect(screen.getByText(/since a run has learned from it/)).toBeVisible();
    expect(screen.queryByRole("button", { name: "Cover another area" })).toBeNull();
    expect(screen.getByRole("button", { name: "Save" })).toBeDisabled();
  });
});
