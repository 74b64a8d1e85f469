import { screen, waitFor } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { describe, expect, it, vi } from "vitest";

import { StatementList } from "@/components/statements/StatementList";
import { RecordedFrames } from "@/lib/game/codec";

import { recording, statement } from "../../support/data";
import { framesFile } from "../../support/frames";
import { show } from "../../support/page";
import { Refusal, serve } from "../../support/server";

const LEFT = "what you steer further to the left";
const MOST = { recording_id: 7, first_frame: 30, n_frames: 12 };
const LEAST = { recording_id: 9, first_frame: 4, n_frames: 12 };
const LIBRARY = "GET /api/behaviours/1/library/recordings";

function open(library: () => unknown = () => [recording({ id: 7 }), recording({ id: 9 })]) {
  const asked = serve({
    [LIBRARY]: library,
    "GET /api/recordings/7/frames": () => framesFile(60),
    "GET /api/recordings/9/frames": () => framesFile(60),
  });
  const statements = [
    statement(LEFT, 0.8, { subjects: ["thing 1 x"], shown: MOST, contrast: LEAST }),
    statement("the game going on longer", 0.1, { subjects: ["time played"] }),
  ];
  show(<StatementList behaviourId={1} statements={statements} answers={[]} answering={null} />);
  return asked;
}

function calm(on: boolean) {
  const list = (query: string) =>
    Object.assign(new EventTarget(), { matches: on && query.includes("reduce"), media: query });
  vi.stubGlobal("matchMedia", list);
}

describe("the moments of a statement", () => {
  it("are fetched once they are shown, and play in a loop within their bounds", async () => {
    calm(false);
    const shown = vi.spyOn(RecordedFrames.prototype, "show");
    const asked = open();
    expect(screen.queryByRole("button", { name: /going on longer/ })).toBeNull();
    expect(asked.filter(({ path }) => path.includes("recordings"))).toEqual([]);
    await userEvent.click(screen.getByRole("button", { name: `Show: ${LEFT}` }));
    expect(await screen.findByRole("img", { name: "Game screen of Recording 7" })).toBeVisible();
    expect(screen.getByRole("img", { name: "Game screen of Recording 9" })).toBeVisible();
    // The playback begins anew after 12 frames: a fifth of a second.
    const framesOf = () => shown.mock.calls.map(([frame]) => frame);
    await waitFor(() => {
      const high = framesOf().filter((frame) => frame >= 30);
      expect(high.some((frame, place) => frame < (high[place - 1] ?? 0))).toBe(true);
    });
    expect(Math.max(...framesOf())).toBeLessThanOrEqual(42);
    expect(framesOf().every((frame) => frame >= 30 || (frame >= 4 && frame <= 16))).toBe(true);

    const hide = screen.getByRole("button", { name: `Hide: ${LEFT}` });
    expect(hide).toHaveAttribute("aria-expanded", "true");
    await userEvent.click(hide);
    expect(screen.queryByRole("img", { name: /^Game screen/ })).toBeNull();
    shown.mockRestore();
  });

  it("stand still where the system asks for less motion", async () => {
    calm(true);
    const shown = vi.spyOn(RecordedFrames.prototype, "show");
    open();
    await userEvent.click(screen.getByRole("button", { name: `Show: ${LEFT}` }));
    await screen.findByRole("img", { name: "Game screen of Recording 9" });
    await new Promise((resolve) => setTimeout(resolve, 100));
    expect(new Set(shown.mock.calls.map(([frame]) => frame))).toEqual(new Set([36, 10]));
    shown.mockRestore();
  });

  it("say why one is missing", async () => {
    calm(false);
    open(() => new Refusal(503, { detail: "The disk is away." }));
    await userEvent.click(screen.getByRole("button", { name: `Show: ${LEFT}` }));
    await waitFor(() => expect(screen.getAllByText(/The disk is away\./)).toHaveLength(2));
  });
});
