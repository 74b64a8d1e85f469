import { fireEvent, screen, waitFor, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { describe, expect, it, vi } from "vitest";

import type { NamedThings } from "@/api/types";
import { PointDialog } from "@/features/ranking/understanding/PointDialog";

import { KnownRecordings } from "@/features/ranking/recording-names";

import { recording } from "../../../support/data";
import { framesFile } from "../../../support/frames";
import { show } from "../../../support/page";
import { type Asked, Refusal, serve } from "../../../support/server";

const PLACE = { subjects: ["thing 1 x"], sentence: "what you steer further to the left or right" };
const BALLS = { subjects: ["thing 2 count"], sentence: "more or fewer of the ball" };
const TIME = { subjects: ["time played"], sentence: "the game going on longer or less long" };
const NAMED: NamedThings = {
  things: [
    {
      kind: 1,
      key: "40:1-2x3-4",
      name: "what you steer",
      given: null,
      picture: "/1.png",
      meanings: [PLACE],
    },
    { kind: 4, key: "14:2-2x2-2", name: "the ball", given: null, picture: null, meanings: [BALLS] },
  ],
  others: [TIME],
};
const IN_SIGHT = [
  { kind: 1, left: 40, top: 105, width: 16, height: 21 },
  { kind: 4, left: 80, top: 42, width: 2, height: 2 },
  { kind: 4, left: 90, top: 42, width: 2, height: 2 },
];

const [STEERED, BALL] = NAMED.things;
const RENAMED = {
  ...NAMED,
  things: [
    STEERED,
    {
      ...BALL,
      name: "the puck",
      given: "puck",
      meanings: [{ ...BALLS, sentence: "more or fewer of the puck" }],
    },
  ],
};

function open(named: () => unknown = () => NAMED, rename: () => unknown = () => RENAMED) {
  const onMean = vi.fn();
  let things = named;
  const asked = serve({
    "GET /api/behaviours/1/ranking/things": () => things(),
    "PUT /api/behaviours/1/ranking/things/names": () => {
      const answer = rename();
      if (!(answer instanceof Refusal)) things = rename;
      return answer;
    },
    "GET /api/behaviours/1/ranking/things/in-sight": ({ query }: Asked) =>
      query.get("recording_id") === "7" ? IN_SIGHT : [],
    "GET /api/behaviours/1/library/recordings": ({ query }: Asked) =>
      query.getAll("recording").map((id) => recording({ id: Number(id) })),
    "GET /api/recordings/7/frames": () => framesFile(60),
    "GET /api/recordings/9/frames": () => framesFile(60),
  });
  const known = new Map([7, 9].map((id) => [id, recording({ id })]));
  show(
    <KnownRecordings value={known}>
      <PointDialog behaviourId={1} recordingIds={[7, 9]} onMean={onMean} onClose={vi.fn()} />
    </KnownRecordings>,
  );
  return { asked, onMean };
}

const boxes = () => [...document.querySelectorAll<HTMLElement>("[data-kind]")];
const stepsAsked = (asked: readonly Asked[]) =>
  asked.filter(({ path }) => path.endsWith("/in-sight")).map(({ query }) => query.get("step"));

describe("pointing at a thing", () => {
  it("marks all of its kind in the picture, and says what of it may be meant", async () => {
    const { onMean } = open();
    await waitFor(() => expect(boxes()).toHaveLength(3));
    expect(boxes()[0]).toHaveStyle({ left: "25%", top: "50%", width: "10%", height: "10%" });
    const ball = boxes()[1] ?? document.body;
    await userEvent.hover(ball);
    const marked = () => boxes().filter(({ className }) => className.includes("marked"));
    expect(marked().map((box) => box.dataset.kind)).toEqual(["4", "4"]);
    expect(screen.getByRole("button", { name: "the ball" }).className).toContain("marked");
    await userEvent.click(ball);
    expect(screen.getByRole("heading", { name: "the ball" })).toHaveFocus();
    await userEvent.click(screen.getByRole("button", { name: BALLS.sentence }));
    expect(onMean).toHaveBeenCalledExactlyOnceWith(BALLS);
  });

  it("works by the keyboard alone, and leads back to the other things", async () => {
    const { onMean } = open();
    const player = await screen.findByRole("button", { name: "what you steer" });
    player.focus();
    await waitFor(() => expect(boxes()[0]?.className).toContain("marked"));
    await userEvent.keyboard("{Enter}");
    expect(await screen.findByRole("list", { name: "What you mean about it" })).toBeVisible();
    await userEvent.click(screen.getByRole("button", { name: "Another thing" }));
    const others = within(screen.getByRole("list", { name: "Something else" }));
    await userEvent.click(others.getByRole("button", { name: TIME.sentence }));
    expect(onMean).toHaveBeenCalledExactlyOnceWith(TIME);
  });

  it("shows another moment, or another game, and asks what is in sight there", async () => {
    const { asked } = open();
    await waitFor(() => expect(boxes()).toHaveLength(3));
    // A third of the game of 15 steps; steps count from 0 there.
    expect(stepsAsked(asked)).toEqual(["4"]);
    const position = screen.getByRole("slider", { name: "Position in the recording" });
    fireEvent.change(position, { target: { value: "41" } });
    expect(boxes()).toEqual([]);
    await waitFor(() => expect(stepsAsked(asked)).toEqual(["4", "10"]));
    await userEvent.click(screen.getByRole("button", { name: "One step forward" }));
    await waitFor(() => expect(stepsAsked(asked)).toEqual(["4", "10", "11"]));
    await userEvent.selectOptions(screen.getByRole("combobox", { name: "Game" }), "Recording 9");
    await waitFor(() => expect(stepsAsked(asked)).toHaveLength(4));
  });

  it("gives a thing a name, by which everything is told afterwards", async () => {
    const { asked } = open();
    await userEvent.click(await screen.findByRole("button", { name: "the ball" }));
    await userEvent.click(screen.getByRole("button", { name: "Give it a name" }));
    const name = screen.getByRole("textbox", { name: "Name" });
    expect(name).toHaveFocus();
    await userEvent.type(name, " puck {Enter}");
    const title = await screen.findByRole("heading", { name: "the puck" });
    expect(title).toHaveFocus();
    expect(screen.getByRole("button", { name: "more or fewer of the puck" })).toBeVisible();
    expect(asked.filter(({ method }) => method === "PUT").map(({ body }) => body)).toEqual([
      { key: "14:2-2x2-2", name: "puck" },
    ]);
    await userEvent.click(screen.getByRole("button", { name: "Rename" }));
    expect(screen.getByRole("textbox", { name: "Name" })).toHaveValue("puck");
    expect(screen.getByText(/Leave it empty to use Tril’s own name/)).toBeVisible();
    await userEvent.keyboard("{Escape}");
    expect(screen.getByRole("heading", { name: "the puck" })).toHaveFocus();
  });

  it("keeps a name that is refused, and says why", async () => {
    open(
      undefined,
      () => new Refusal(422, { detail: "This name has a character that is not text." }),
    );
    await userEvent.click(await screen.findByRole("button", { name: "the ball" }));
    await userEvent.click(screen.getByRole("button", { name: "Give it a name" }));
    await userEvent.type(screen.getByRole("textbox", { name: "Name" }), "puck{Enter}");
    expect(await screen.findByText(/a character that is not text/)).toBeVisible();
    expect(screen.getByRole("textbox", { name: "Name" })).toHaveValue("puck");
  });

  it("says why nothing can be pointed at", async () => {
    open(() => new Refusal(404, { detail: "Tril has not learned to see this game yet." }));
    expect(await screen.findByText(/has not learned to see this game yet/)).toBeVisible();
  });
});
