import { fireEvent, screen, waitFor, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { describe, expect, it, vi } from "vitest";

import type { Recording, RecordingCourse, Run } from "@/api/types";
import { RecordingPage } from "@/features/recordings/RecordingPage";

import { behaviour, recording, run } from "../../support/data";
import { framesFile } from "../../support/frames";
import { show } from "../../support/page";
import { Refusal, serve } from "../../support/server";

const N_FRAMES = 24;

function course(change: Partial<RecordingCourse> = {}): RecordingCourse {
  return {
    actions: Array.from({ length: N_FRAMES }, (_, index) => (index < 8 ? 2 : 1)),
    parent: null,
    branches: [],
    conditions: {},
    memory_url: "/api/recordings/1/memory?v=1",
    memory_names: [{ address: 28, name: "cannon, x" }],
    ...change,
  };
}

/** RAM in which the cannon's position is the frame number. */
function memory(): ArrayBuffer {
  const bytes = new Uint8Array((N_FRAMES + 1) * 128);
  for (let frame = 0; frame <= N_FRAMES; frame += 1) bytes[frame * 128 + 28] = frame;
  return bytes.buffer;
}

const NEWEST = "aaaaaa00-0000-4000-8000-000000000000";
const OLDER = "bbbbbb00-0000-4000-8000-000000000000";

/** R of the seven states of the recording by two runs. */
function trace(runId: string) {
  const sign = runId === NEWEST ? 1 : -1;
  const levels = Array.from({ length: 7 }, (_, step) => (sign * step) / 6);
  const deviations = runId === NEWEST ? levels.map(() => 0.08) : null;
  return {
    run_id: runId,
    recording_id: 1,
    rewards: levels,
    zero_level_reward: 0,
    unit_level_reward: 1,
    levels,
    reward_deviations: deviations,
    level_deviations: deviations,
  };
}

function page(
  change: Partial<Recording> = {},
  of: Partial<RecordingCourse> = {},
  path = "/",
  runs: readonly Run[] = [],
  exactMap: Promise<unknown> = Promise.resolve(),
  one = behaviour(),
) {
  const shown = recording({
    n_frames: N_FRAMES,
    n_steps: 6,
    hits: [
      { row: 0, column: 0, frame: 9, on_target: true },
      { row: 2, column: 3, frame: 17, on_target: false },
    ],
    ...change,
  });
  const asked = serve({
    "GET /api/recordings/1/frames": () => framesFile(N_FRAMES),
    "GET /api/runs": () => runs,
    [`GET /api/runs/${NEWEST}/reward/1`]: () => trace(NEWEST),
    [`GET /api/runs/${OLDER}/reward/1`]: () => trace(OLDER),
    [`GET /api/runs/${NEWEST}/attention/1`]: async ({ query }) => {
      if (query.get("method") === "occlusion") await exactMap;
      const values = new Float32Array(84 * 84).fill(0.31).buffer;
      const headers = new Headers();
      if (query.get("network") !== "reward") headers.set("X-Tril-Action", "5");
      return new Response(values, { headers });
    },
    "GET /api/recordings/1/course": () => course(of),
    "GET /api/recordings/1/memory": memory,
    "GET /api/recordings/1/clip.gif": () => {
      const disposition = 'attachment; filename="column-1-recording-1.gif"';
      return new Response(new ArrayBuffer(8), { headers: { "Content-Disposition": disposition } });
    },
    "GET /api/recordings/1/clip.mp4": () =>
      new Refusal(503, { detail: "Several clips are being made already." }),
    "PATCH /api/recordings/1": () => shown,
    "DELETE /api/recordings/1": () => undefined,
  });
  show(<RecordingPage recording={shown} behaviour={one} />, path);
  return asked;
}

async function position(): Promise<HTMLInputElement> {
  return screen.findByRole<HTMLInputElement>("slider", { name: "Position in the recording" });
}

describe("the page of a recording", () => {
  it("goes to any frame by keys", async () => {
    page();
    const slider = await position();
    expect(slider.valueAsNumber).toBe(0);
    const keys: [string, number][] = [
      ["{ArrowRight}", 1],
      ["{Shift>}{ArrowRight}{/Shift}", 5],
      ["{ArrowLeft}", 4],
      ["{End}", N_FRAMES],
      ["{ArrowRight}", N_FRAMES],
      ["{Shift>}{ArrowLeft}{/Shift}", N_FRAMES - 4],
      ["{Home}", 0],
    ];
    for (const [key, frame] of keys) {
      await userEvent.keyboard(key);
      expect(slider.valueAsNumber, key).toBe(frame);
    }
  });

  it("begins at the frame that its address names, standing still", async () => {
    page({}, {}, "/?frame=12");
    expect((await position()).valueAsNumber).toBe(12);
    expect(screen.getByRole("button", { name: "Play" })).toBeVisible();
  });

  it("says which action led to each frame", async () => {
    page();
    await position();
    expect(await screen.findByText("the start")).toBeVisible();
    await userEvent.keyboard("{ArrowRight}");
    expect(screen.getByText("right")).toBeVisible();
    await userEvent.keyboard("{End}");
    expect(screen.getByText("fire")).toBeVisible();
  });

  it("says nothing of hits without a target", async () => {
    page({}, {}, "/", [], undefined, behaviour({ target: null }));
    await position();
    expect(screen.queryByRole("list", { name: "Hits" })).toBeNull();
    expect(screen.queryByRole("img", { name: /hits/i })).toBeNull();
    expect(screen.queryByText(/alien/i)).toBeNull();
  });

  it("tells strays from hits in words, and goes to a hit when it is pressed", async () => {
    page();
    const slider = await position();
    const hits = within(screen.getByRole("list", { name: "Hits" }));
    const [first, stray] = hits.getAllByRole("button");
    expect(first).not.toHaveTextContent("stray");
    expect(stray).toHaveTextContent("0.28 s row 3, column 4 × stray");
    if (stray) await userEvent.click(stray);
    expect(slider.valueAsNumber).toBe(17);
    expect(
      screen.getByRole("img", {
        name: "Hits: row 1, column 1 at 0.1\u00a0s; stray, row 3, column 4 at 0.3\u00a0s",
      }),
    ).toBeInTheDocument();
  });

  it("shows the memory only when asked for, and that of the present frame", async () => {
    const asked = page();
    await position();
    expect(asked.some(({ path }) => path.endsWith("/memory"))).toBe(false);
    await userEvent.click(await screen.findByText("Console memory"));
    await screen.findByRole("table", { name: "Memory at frame 0" });
    await userEvent.click(screen.getByRole("button", { name: "One frame forward" }));
    const bytes = within(screen.getByRole("table", { name: "Memory at frame 1" }));
    expect(bytes.getByTitle("28: cannon, x, 1")).toHaveTextContent("01");
    const names = within(screen.getByRole("table", { name: "Known addresses" }));
    expect(names.getByRole("row", { name: "28 cannon, x 1" })).toBeVisible();
  });

  it("leads to what it goes on from and to what goes on from it", async () => {
    page(
      {},
      {
        parent: { recording_id: 7, number: 2, frame: 90 },
        branches: [{ recording_id: 9, number: 4, frame: 3 }],
      },
    );
    expect(await screen.findByRole("link", { name: "recording 2, frame 90" })).toHaveAttribute(
      "href",
      "/recordings/7?frame=90",
    );
    expect(screen.getByRole("link", { name: "Recording 4" })).toHaveAttribute(
      "href",
      "/recordings/9?frame=3",
    );
  });

  it("keeps notes and marks", async () => {
    const asked = page();
    await userEvent.click(await screen.findByRole("button", { name: "Write a note" }));
    await userEvent.type(screen.getByLabelText("Note"), "Home run");
    await userEvent.click(screen.getByRole("button", { name: "Save note" }));
    await userEvent.click(screen.getByRole("button", { name: "Mark as perfect" }));
    await userEvent.click(screen.getByRole("button", { name: "Mark all the same" }));
    await waitFor(() =>
      expect(asked.filter(({ method }) => method === "PATCH").map(({ body }) => body)).toEqual([
        { notes: "Home run" },
        { perfect: true },
      ]),
    );
  });

  it("downloads a clip under the name that the server gives it, and says why it could not be made", async () => {
    const saved: string[] = [];
    vi.spyOn(HTMLAnchorElement.prototype, "click").mockImplementation(function click(
      this: HTMLAnchorElement,
    ) {
      saved.push(`${this.download} ${this.href}`);
    });
    URL.createObjectURL = () => "blob:clip";
    const asked = page();
    await userEvent.click(await screen.findByRole("button", { name: "GIF" }));
    await waitFor(() => expect(saved).toEqual(["column-1-recording-1.gif blob:clip"]));
    expect(asked.find(({ path }) => path.endsWith("clip.gif"))?.query.get("v")).toBe("1");
    await userEvent.click(await screen.findByRole("button", { name: "MP4" }));
    expect(await screen.findByText("Several clips are being made already.")).toBeVisible();
    expect(saved).toHaveLength(1);
    expect(screen.getByRole("link", { name: "Data (JSON)" })).toHaveAttribute(
      "href",
      "/api/recordings/1/export",
    );
  });

  describe("with runs", () => {
    const runs = [
      run({ id: "cccccc00-0000-4000-8000-000000000000", status: "running" }),
      run({ id: NEWEST, status: "done" }),
      run({ id: OLDER, status: "done", recipe: "paper" }),
    ];
    const curve = () => screen.findByRole("slider", { name: "Position on the curve of R" });

    it("plots the reward of the newest finished one, in step with the picture", async () => {
      page({}, {}, "/?step=3", runs);
      expect(await curve()).toHaveAttribute("aria-valuetext", "step 3, R 0.50 ± 0.08");
      (await curve()).focus();
      await userEvent.keyboard("{Shift>}{ArrowRight}{/Shift}");
      expect((await position()).valueAsNumber).toBe(16);
      expect(screen.getByText("R 0.67 ± 0.08 at step 4")).toBeVisible();
      expect(screen.getByText(/Band: ± one standard deviation/)).toBeVisible();
      await userEvent.keyboard("{Home}");
      expect(await curve()).toHaveAttribute("aria-valuetext", "step 0, R 0.00 ± 0.08");
    });

    it("moves the picture when the curve is dragged", async () => {
      page({}, {}, "/", runs);
      const plot = await curve();
      const captured = new Set<number>();
      plot.setPointerCapture = (id) => captured.add(id);
      plot.hasPointerCapture = (id) => captured.has(id);
      plot.getBoundingClientRect = () => new DOMRect(100, 0, 240, 96);
      const slider = await position();
      fireEvent.pointerMove(plot, { clientX: 220, pointerId: 1 });
      expect(slider.valueAsNumber).toBe(0);
      fireEvent.pointerDown(plot, { clientX: 160, pointerId: 1, button: 0 });
      expect(slider.valueAsNumber).toBe(6);
      fireEvent.pointerMove(plot, { clientX: 220, pointerId: 1 });
      expect(slider.valueAsNumber).toBe(12);
      fireEvent.pointerMove(plot, { clientX: 999, pointerId: 1 });
      expect(slider.valueAsNumber).toBe(N_FRAMES);
    });

    it("chooses another one from the menu, and from the address", async () => {
      page({}, {}, `/?step=3&run=${OLDER}`, runs);
      expect(await curve()).toHaveAttribute("aria-valuetext", "step 3, R −0.50");
      expect(screen.queryByText(/standard deviation/)).toBeNull();
      const menu = screen.getByRole("combobox", { name: "Reward model of" });
      expect(within(menu).getAllByRole("option")).toHaveLength(2);
      await userEvent.selectOptions(menu, NEWEST);
      await waitFor(async () =>
        expect(await curve()).toHaveAttribute("aria-valuetext", "step 3, R 0.50 ± 0.08"),
      );
    });

    it("shows what the reward looks at, quickly and then exactly", async () => {
      let compute: () => void = () => undefined;
      const computed = new Promise<void>((resolve) => {
        compute = resolve;
      });
      const asked = page({}, {}, "/?step=2", runs, computed);
      await curve();
      await userEvent.click(screen.getByRole("button", { name: "What the reward looks at" }));
      expect(await screen.findByText(/Step 2, estimated by the gradient/)).toBeVisible();
      expect(screen.getByRole("img", { name: "What the reward looks at in step 2" })).toBeVisible();
      await userEvent.keyboard("{Shift>}{ArrowRight}{/Shift}");
      expect(await screen.findByText(/Step 3, estimated by the gradient/)).toBeVisible();
      compute();
      expect(await screen.findByText(/Step 3, exact/)).toBeVisible();
      const maps = asked.filter(({ path }) => path.includes("/attention/"));
      expect(maps.map(({ query }) => `${query.get("step")} ${query.get("method")}`)).toEqual([
        "2 gradient",
        "2 occlusion",
        "3 gradient",
        "3 occlusion",
      ]);
      expect(maps.map(({ signal }) => signal.aborted)).toEqual([false, true, false, false]);
      fireEvent.change(screen.getByRole("slider", { name: "Opacity" }), {
        target: { value: "30" },
      });
      expect(screen.getByRole("img", { name: /looks at in step 3/ })).toHaveStyle({
        opacity: "0.3",
      });
    });

    it("follows a recording that plays with quick maps", async () => {
      const asked = page({}, {}, "/?step=2", runs);
      await curve();
      await userEvent.click(screen.getByRole("button", { name: "What the reward looks at" }));
      await userEvent.click(screen.getByRole("button", { name: "Play" }));
      expect(await screen.findByText(/several times a second\. Pause for the exact/)).toBeVisible();
      const methods = () =>
        asked
          .filter(({ path }) => path.includes("/attention/"))
          .slice(2)
          .map(({ query }) => query.get("method"));
      await waitFor(() => expect(methods().length).toBeGreaterThan(1));
      expect(new Set(methods())).toEqual(new Set(["gradient"]));
      // The picture of a step goes with the next one.
      await waitFor(() =>
        expect(screen.getByRole("img", { name: /What the reward looks at in step/ })).toBeVisible(),
      );
    });

    it("shows what a policy looks at, and by larger patches", async () => {
      const asked = page({}, {}, "/?step=2", runs);
      await curve();
      await userEvent.click(screen.getByRole("button", { name: "What the reward looks at" }));
      expect(await screen.findByRole("img", { name: "Colours: from 0 to 0.31 R" })).toBeVisible();
      const whose = screen.getByRole("combobox", { name: "Whose attention" });
      await userEvent.selectOptions(whose, "Clone");
      const how = screen.getByRole("combobox", { name: "How it is mapped" });
      await userEvent.selectOptions(how, "9×9 pixels, all four screens");
      expect(
        await screen.findByText(
          /the logit of “left and fire” changes .* The clone chooses “left and fire” here\./,
        ),
      ).toHaveTextContent("9×9 pixels of all four screens");
      expect(screen.getByRole("img", { name: "Colours: from 0 to 0.31 logits" })).toBeVisible();
      expect(screen.getByRole("img", { name: "What the clone looks at in step 2" })).toBeVisible();
      await userEvent.selectOptions(how, "Gradient");
      expect(await screen.findByText(/estimated by the gradient of the logit/)).toBeVisible();
      const last = asked.filter(({ path }) => path.includes("/attention/")).at(-1)?.query;
      expect([last?.get("network"), last?.get("method")]).toEqual(["clone", "patches"]);
    });

    it("says where there is no reward, and what to do", async () => {
      page({}, {}, "/", runs.slice(0, 1));
      expect(
        await screen.findByText(/No run of Column 1 has finished yet, so there is no learned/),
      ).toBeVisible();
      expect(screen.getByRole("link", { name: "Look at its runs" })).toHaveAttribute(
        "href",
        "/behaviours/1/runs",
      );
      expect(screen.queryByRole("slider", { name: "Position on the curve of R" })).toBeNull();
    });
  });

  it("offers no deletion of what belongs to a training", async () => {
    page({ run_id: "3f2a9c00-0000-4000-8000-000000000000", source: "policy" });
    await position();
    expect(screen.queryByRole("button", { name: "Delete" })).toBeNull();
    expect(
      screen.getByRole("link", { name: /The run whose imitator or clone played it/ }),
    ).toBeVisible();
  });
});
