import { fireEvent, render, screen, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { useState } from "react";
import { describe, expect, it } from "vitest";

import type { Measure, ReadyMade, TaughtGame } from "@/api/types";
import { MeasureChecklist } from "@/features/recordings/MeasureChecklist";
import { GamePage } from "@/features/behaviours/games/GamePage";
import { kindsOf, newMeasure, orderOf, orders } from "@/features/behaviours/measures/drafts";
import { MeasureBuilder } from "@/features/behaviours/measures/MeasureBuilder";
import { MeasureTable } from "@/features/results/games/MeasureTable";
import { GameProvider } from "@/games/game";

import { behaviour } from "../../support/data";
import { CART_POLE, gameRoutes, PONG, SPACE_INVADERS } from "../../support/games";
import { show } from "../../support/page";
import { serve } from "../../support/server";

const UP: Measure = { kind: "region", thing: "player", area: [0, 34, 160, 114], at_least: 0.9 };

describe("a new measure", () => {
  it("is of a kind that the game allows", () => {
    expect(kindsOf(SPACE_INVADERS)).toHaveLength(9);
    expect(kindsOf(PONG)).not.toContain("items");
    expect(kindsOf({ ...CART_POLE, things: {} })).toEqual(["rate", "score", "alive", "length"]);
  });

  it("names what there is in the game", () => {
    expect(newMeasure("nearness", PONG)).toMatchObject({ thing: "player", other: "opponent" });
    expect(newMeasure("counter", SPACE_INVADERS)).toMatchObject({ counter: "shots" });
    expect(newMeasure("region", PONG).area).toEqual([0, 0, 80, 210]);
  });
});

describe("orders of items", () => {
  it("have a group for each row, and a sequence for each side", () => {
    const found = Object.fromEntries(
      orders(SPACE_INVADERS).map(({ name, sequences }) => [name, sequences]),
    );
    expect(found["rows-up"]?.[0]?.[0]).toEqual([0, 1, 2, 3, 4, 5].map((column) => [0, column]));
    const outside = found.outside?.map((groups) => groups.map((cells) => cells[0]?.[1]));
    expect(outside).toEqual([
      [0, 1, 2],
      [5, 4, 3],
    ]);
  });

  it("are known again however their cells are listed", () => {
    const sequences = orders(SPACE_INVADERS)[4]?.sequences ?? [];
    const other = sequences.map((groups) => groups.map((cells) => cells.toReversed())).toReversed();
    expect(orderOf(other, SPACE_INVADERS)).toBe("outside");
    expect(orderOf([[[[0, 0]]]], SPACE_INVADERS)).toBeNull();
  });
});

function build(game: TaughtGame, initial: readonly Measure[] = []) {
  const seen: { last: readonly Measure[] } = { last: initial };
  function Form() {
    const [value, setValue] = useState(initial);
    seen.last = value;
    return (
      <GameProvider game={game} settings={{ options: {} }}>
        <MeasureBuilder value={value} onChange={setValue} />
      </GameProvider>
    );
  }
  render(<Form />);
  return seen;
}

describe("building a measure", () => {
  it("picks a thing and an area, and says it in a sentence", async () => {
    const seen = build(PONG);
    await userEvent.click(screen.getByText("Measure how well a game shows it"));
    await userEvent.click(screen.getByRole("button", { name: "Measure something" }));
    const measure = within(
      screen.getByRole("group", {
        name: "Green paddle in the left 50% of the screen: at least 90% of the time",
      }),
    );
    await userEvent.selectOptions(measure.getByLabelText("Thing"), "Ball");
    fireEvent.change(measure.getByLabelText("Bottom"), { target: { value: "114" } });
    fireEvent.change(measure.getByLabelText("At least, % of the time"), {
      target: { value: "75" },
    });
    expect(seen.last).toEqual([
      { kind: "region", thing: "ball", area: [0, 0, 80, 114], at_least: 0.75 },
    ]);
    const area = measure.getByRole("button", { name: "Area 1: from 0, 0 to 80, 114" });
    area.focus();
    await userEvent.keyboard("{ArrowRight}");
    expect(seen.last[0]?.area).toEqual([1, 0, 81, 114]);
  });

  it("draws one area instead of another on the game's picture", () => {
    const seen = build(PONG, [UP]);
    const stage = screen.getByAltText("The game, some seconds after its start").parentElement;
    if (!stage) throw new Error("There is no picture.");
    stage.getBoundingClientRect = () => new DOMRect(0, 0, 160, 210);
    stage.setPointerCapture = () => undefined;
    fireEvent.pointerDown(stage, { button: 0, clientX: 10, clientY: 20 });
    fireEvent.pointerMove(stage, { clientX: 50, clientY: 60 });
    fireEvent.pointerUp(stage);
    expect(seen.last[0]?.area).toEqual([10, 20, 50, 60]);
  });

  it("changes the kind, empties a bound and removes a measure", async () => {
    const seen = build(SPACE_INVADERS, [{ kind: "score", at_least: 100 }]);
    fireEvent.change(screen.getByLabelText("At least, points"), { target: { value: "" } });
    expect(seen.last).toEqual([{ kind: "score", at_least: null }]);
    await userEvent.selectOptions(
      screen.getByLabelText("What is measured"),
      "In which order it is taken",
    );
    await userEvent.selectOptions(
      screen.getByLabelText("Aliens hit"),
      "columns from the inside out",
    );
    expect(orderOf(seen.last[0]?.sequences, SPACE_INVADERS)).toBe("inside");
    await userEvent.click(screen.getByRole("button", { name: "Remove measure 1" }));
    expect(seen.last).toEqual([]);
  });

  it("does not take a bound of presses for one of the time held", async () => {
    const seen = build(PONG, [{ kind: "rate", button: "fire", per: "second", at_most: 3 }]);
    await userEvent.selectOptions(screen.getByLabelText("Counted"), "how long it is held");
    expect(seen.last[0]).toMatchObject({ per: "time", at_most: null });
  });
});

describe("the checklist of a recording", () => {
  it("shows each value and whether it is met", () => {
    const measured = [
      { value: 0.95, met: true, known: true, unit: "share" as const },
      { value: 0, met: false, known: true, unit: "yes" as const },
    ];
    render(
      <GameProvider game={PONG} settings={{ options: {} }}>
        <MeasureChecklist
          recording={{ measured }}
          behaviour={behaviour({ measures: [UP, { kind: "alive" }] })}
        />
      </GameProvider>,
    );
    const [up, alive] = screen.getAllByRole("listitem");
    if (!up || !alive) throw new Error("Expected two measures.");
    expect(up).toHaveTextContent("95% of the time");
    expect(within(up).getByRole("img", { name: "met" })).toBeVisible();
    expect(within(alive).getByRole("img", { name: "not met" })).toBeVisible();
  });
});

describe("the table of a run's measures", () => {
  it("has a column for people only where they have played", () => {
    const row = {
      measure: UP,
      unit: "share" as const,
      imitator: { n: 4, mean: 0.925, n_met: 3 },
      clone: null,
      person: null,
    };
    const table = (person: typeof row.imitator | null) => (
      <GameProvider game={PONG} settings={{ options: {} }}>
        <MeasureTable rows={[{ ...row, person }]} />
      </GameProvider>
    );
    const { rerender } = render(table(null));
    expect(screen.getAllByRole("columnheader")).toHaveLength(2);
    expect(screen.getByRole("row", { name: /Green paddle/ })).toHaveTextContent(
      /93% of the time.*met in 3 of 4.*–/,
    );
    rerender(table({ n: 2, mean: 1, n_met: 2 }));
    expect(screen.getAllByRole("columnheader")).toHaveLength(3);
  });
});

describe("ready-made behaviours", () => {
  const READY: ReadyMade = {
    slug: "stay-up",
    name: "Stay up",
    description: "Keep the paddle in the upper half.",
    target: null,
    ordered: false,
    settings: { options: {} },
    measures: [UP],
  };

  it("are offered under their game and taken with their measures", async () => {
    const pong = { ...PONG, ready_made: [READY] };
    const asked = serve({
      ...gameRoutes(pong),
      "GET /api/player": () => ({ id: 1, name: "Ada", role: "owner" }),
      "GET /api/behaviours": () => [behaviour()],
      "POST /api/behaviours": () => behaviour({ id: 9, game: "pong" }),
    });
    show(<GamePage name="pong" />);
    await userEvent.click(await screen.findByRole("button", { name: "Teach Stay up" }));
    const dialog = within(screen.getByRole("dialog"));
    expect(dialog.getByLabelText("Name")).toHaveValue("Stay up");
    await userEvent.click(await dialog.findByRole("button", { name: "Create behaviour" }));
    await screen.findByText("Another page");
    expect(asked.find(({ method }) => method === "POST")?.body).toMatchObject({
      game: "pong",
      name: "Stay up",
      measures: [UP],
    });
  });

  it("are not offered once they are there", async () => {
    serve({
      ...gameRoutes({ ...PONG, ready_made: [READY] }),
      "GET /api/player": () => ({ id: 1, name: "Ada", role: "owner" }),
      "GET /api/behaviours": () => [behaviour({ id: 4, game: "pong", name: "Stay up" })],
    });
    show(<GamePage name="pong" />);
    expect(await screen.findByRole("link", { name: "Stay up" })).toBeVisible();
    expect(screen.queryByRole("heading", { name: "Ready-made" })).toBeNull();
  });
});
