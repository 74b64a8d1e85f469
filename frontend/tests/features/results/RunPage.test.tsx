import { cleanup, fireEvent, screen, waitFor, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { describe, expect, it, vi } from "vitest";

import { hasGpu } from "@/api/system";
import type { PolicySummary, Recording, Run, RunResults, System } from "@/api/types";
import { RunPage } from "@/features/results/RunPage";
import { RunsPage } from "@/features/results/RunsPage";

import {
  behaviour,
  game,
  headline,
  recording,
  results,
  run,
  statement,
  system,
} from "../../support/data";
import { framesFile } from "../../support/frames";
import { libraryOf } from "../../support/library";
import { show } from "../../support/page";
import { Refusal, serve } from "../../support/server";

const INTERVAL = { mean: 4.7, low: 3.9, high: 5.4, n: 23 };
const SUMMARY: PolicySummary = {
  targets: INTERVAL,
  strays: { mean: 0.2, low: 0, high: 0.5, n: 23 },
  order_errors: null,
  steps: { mean: 288, low: 270, high: 300, n: 23 },
  death_rate: { mean: 0.13, low: 0, high: 0.3, n: 23 },
  predicted_return: null,
};

/** Opens the page of a run, at a link into one of its sections. */
function open(
  one: Run,
  change: Partial<RunResults> = {},
  more: Parameters<typeof serve>[0] = {},
  link = "",
) {
  const asked = serve({
    [`GET /api/runs/${one.id}/results`]: () => results(one, change),
    [`GET /api/runs/${one.id}/metrics`]: () => ({
      last: 3,
      series: { imitator: { hits: [[1, 1]], strays: [[1, 0]] } },
    }),
    "GET /api/system": () => system(true),
    ...more,
  });
  show(<RunPage run={one} behaviour={behaviour()} />, `/${link}`);
  return asked;
}

describe("a run for a GPU", () => {
  it("says that it waits for a worker that has one", async () => {
    open(run({ id: "r1", status: "queued", device: "gpu", worker_alive: false }));
    expect(
      await screen.findByText("This run waits for a worker with a GPU; none is running."),
    ).toBeVisible();
  });

  it("counts only workers that are alive and learn on one", () => {
    const withGpu = (alive: boolean): System => ({
      ...system(true),
      processes: system(true).processes.map((one) => ({ ...one, alive, gpu: "NVIDIA T4" })),
    });
    expect(hasGpu(undefined)).toBeNull();
    expect([system(true), withGpu(false), withGpu(true)].map(hasGpu)).toEqual([false, false, true]);
  });
});

describe("a run that is over", () => {
  it("opens with its verdict and leads to what to do next", async () => {
    const verdict = {
      tone: "fair",
      sentence: "The imitator hits 4 of 6 targets.",
      details: "It loses no game.",
      advice: "Train for longer.",
      next_step: "train",
    } as const;
    open(run({ status: "done" }), { verdict });
    const said = within(await screen.findByRole("region", { name: "Verdict" }));
    expect(said.getByText("The imitator hits 4 of 6 targets.")).toBeVisible();
    expect(said.getByRole("link", { name: "Train again" })).toHaveAttribute(
      "href",
      "/behaviours/1/train",
    );
  });
});

describe("taking a run away", () => {
  it("downloads everything as one zip", async () => {
    const one = run({ status: "done" });
    let finish: (content: ArrayBuffer) => void = () => undefined;
    const made = new Promise<ArrayBuffer>((resolve) => (finish = resolve));
    open(one, {}, { [`GET /api/runs/${one.id}/archive.zip`]: () => made }, "#files");
    const saved: string[] = [];
    vi.spyOn(HTMLAnchorElement.prototype, "click").mockImplementation(function (
      this: HTMLAnchorElement,
    ) {
      saved.push(this.download);
    });
    URL.createObjectURL = () => "blob:1";
    const section = within(await screen.findByRole("region", { name: "Take it with you" }));
    await userEvent.click(section.getByRole("button", { name: "Everything as a zip" }));
    expect(section.getByRole("button", { name: "Making the zip…" })).toHaveAttribute(
      "aria-disabled",
      "true",
    );
    finish(new ArrayBuffer(8));
    await section.findByRole("button", { name: "Everything as a zip" });
    expect(saved).toEqual([`tril-${behaviour().slug}-${one.id.slice(0, 8)}.zip`]);
  });

  it("downloads a page to send, from its head, too", async () => {
    const one = run({ status: "done" });
    const page = () => new ArrayBuffer(8);
    const asked = open(
      one,
      {},
      {
        [`GET /api/runs/${one.id}/page.html`]: page,
        [`GET /api/runs/${one.id}/page.png`]: page,
      },
    );
    const saved: string[] = [];
    vi.spyOn(HTMLAnchorElement.prototype, "click").mockImplementation(function (
      this: HTMLAnchorElement,
    ) {
      saved.push(this.download);
    });
    URL.createObjectURL = () => "blob:1";
    const name = `tril-${behaviour().slug}-${one.id.slice(0, 8)}`;
    for (const button of ["Share", "One page to send", "Its poster"]) {
      await userEvent.click(await screen.findByRole("button", { name: button }));
    }
    await waitFor(() => expect(saved).toEqual([`${name}.html`, `${name}.html`, `${name}.png`]));
    expect(asked.filter(({ path }) => /page\.(html|png)$/.test(path))).toHaveLength(3);
  });

  it("keeps the focus on Share and announces what was saved", async () => {
    const one = run({ status: "done" });
    let finish: (content: ArrayBuffer) => void = () => undefined;
    const made = new Promise<ArrayBuffer>((resolve) => (finish = resolve));
    const asked = open(one, {}, { [`GET /api/runs/${one.id}/page.html`]: () => made });
    vi.spyOn(HTMLAnchorElement.prototype, "click").mockImplementation(() => undefined);
    URL.createObjectURL = () => "blob:1";
    await userEvent.click(await screen.findByRole("button", { name: "Share" }));
    const making = screen.getByRole("button", { name: "Making the page…" });
    expect(making).toHaveFocus();
    await userEvent.keyboard("{Enter}");
    finish(new ArrayBuffer(8));
    const messages = screen.getByRole("status", { name: "Messages" });
    const name = `tril-${behaviour().slug}-${one.id.slice(0, 8)}.html`;
    await waitFor(() =>
      expect(messages).toHaveTextContent(`The page was saved as ${name}. It opens in any browser.`),
    );
    expect(screen.getByRole("button", { name: "Share" })).toHaveFocus();
    expect(asked.filter(({ path }) => path.endsWith("/page.html"))).toHaveLength(1);
  });

  it("says why that failed", async () => {
    const one = run({ status: "done" });
    const refusal = new Refusal(503, { detail: "Several archives are being made already." });
    open(one, {}, { [`GET /api/runs/${one.id}/archive.zip`]: () => refusal }, "#files");
    await userEvent.click(await screen.findByRole("button", { name: "Everything as a zip" }));
    expect(await screen.findByText("Several archives are being made already.")).toBeVisible();
  });

  it("is not offered before the run is done", async () => {
    open(run());
    await screen.findByRole("figure", { name: "Hits per game" });
    expect(screen.queryByRole("region", { name: "Take it with you" })).toBeNull();
  });
});

describe("a run that goes", () => {
  it("says how far it is, stage by stage", async () => {
    open(run());
    expect(screen.getByText("60%")).toBeVisible();
    expect(screen.getByText("about 2 min left")).toBeVisible();
    const stages = screen
      .getAllByRole("progressbar")
      .map((bar) => bar.getAttribute("aria-valuenow"));
    expect(stages).toEqual(["100", "100", "100", "100", "50", "0", "0"]);
    expect(await screen.findByRole("figure", { name: "Hits per game" })).toBeVisible();
  });

  it("shows no time left while it is being cancelled", () => {
    open(run({ status: "cancelling" }));
    expect(
      within(screen.getByRole("region", { name: "Progress" })).getByText("Cancelling"),
    ).toBeVisible();
    expect(screen.queryByText(/left$/)).toBeNull();
  });

  it("can be cancelled", async () => {
    const one = run();
    const asked = open(
      one,
      {},
      {
        [`POST /api/runs/${one.id}/cancel`]: () => run({ status: "cancelling" }),
      },
    );
    await userEvent.click(screen.getByRole("button", { name: "Cancel run" }));
    await waitFor(() => expect(asked.some(({ path }) => path.endsWith("/cancel"))).toBe(true));
  });
});

describe("a run whose return rises alone", () => {
  const alarm = { from_step: 1000, to_step: 9000, message: "It rose, but hits did not." };

  it("is alarmed while it goes, with where to look", async () => {
    open(run(), { alarm });
    const said = await screen.findByRole("alert");
    expect(said).toHaveTextContent("The reward may be hacked. It rose, but hits did not.");
    expect(within(said).getByRole("link", { name: "See the curves" })).toHaveAttribute(
      "href",
      "/#curves",
    );
    expect(within(said).queryByRole("link", { name: /watch/ })).not.toBeInTheDocument();
  });

  it("leads to its games once there are some", async () => {
    const row = { start_number: 0, held_out: true, imitator: null, clone: null, winner: null };
    open(run({ status: "done" }), { alarm, comparison: [row] });
    const said = await screen.findByRole("alert");
    expect(within(said).getByRole("link", { name: "watch the games" })).toHaveAttribute(
      "href",
      "/#games",
    );
  });
});

describe("the curves of a run", () => {
  it("are zoomed by buttons and saved as CSV", async () => {
    const save = vi.spyOn(HTMLAnchorElement.prototype, "click").mockImplementation(() => undefined);
    const saved: Blob[] = [];
    vi.stubGlobal(
      "URL",
      Object.assign(URL, {
        createObjectURL: (blob: Blob) => {
          saved.push(blob);
          return "blob:curves";
        },
      }),
    );
    const one = run({ status: "done" });
    const series = { imitator: { hits: [1, 2, 3, 4].map((step) => [step, step / 2]) } };
    open(one, {}, { [`GET /api/runs/${one.id}/metrics`]: () => ({ last: 4, series }) }, "#curves");
    const bar = within(await screen.findByRole("group", { name: /^Zoom: Imitator/ }));
    await userEvent.click(bar.getByRole("button", { name: "Zoom in" }));
    await userEvent.click(bar.getByRole("button", { name: "Show everything" }));
    expect(bar.queryByRole("button", { name: "Zoom out" })).toBeNull();
    await userEvent.click(screen.getByRole("button", { name: "Download the curves (CSV)" }));
    expect(save).toHaveBeenCalledOnce();
    expect(await saved[0]?.text()).toContain("imitator,hits,4,2");
    save.mockRestore();
  });
});

describe("a run that ended early", () => {
  it("says why, and can go on", async () => {
    const one = run({ status: "stopped", message: "It confuses tiers 1 and 3." });
    const asked = open(
      one,
      {},
      {
        [`POST /api/runs/${one.id}/resume`]: () => new Refusal(409, { detail: "It is queued." }),
      },
    );
    expect(screen.getByText("It confuses tiers 1 and 3.")).toBeVisible();
    await userEvent.click(screen.getByRole("button", { name: "Go on anyway" }));
    expect(await screen.findByText("It is queued.")).toBeVisible();
    expect(asked.some(({ path }) => path.endsWith("/resume"))).toBe(true);
  });

  it("says once that it goes on where it was cancelled before its imitator had played", async () => {
    const message = "Cancelled. It can be resumed and goes on from its last checkpoint.";
    const verdict = {
      tone: "none" as const,
      sentence: "This run was cancelled before its imitator had played.",
      details: "",
      advice: "Resume it: it goes on from its last checkpoint.",
      next_step: null,
    };
    open(run({ status: "cancelled", message, headline: null }), { verdict });
    expect(await screen.findByText(verdict.advice)).toBeVisible();
    expect(screen.queryByText(message)).toBeNull();
  });

  it("is deleted, and Undo brings it back", async () => {
    const one = run({ name: "Wide", status: "failed", message: "The disk was full." });
    const asked = open(
      one,
      {},
      {
        [`DELETE /api/runs/${one.id}`]: () => undefined,
        [`POST /api/runs/${one.id}/restore`]: () => one,
      },
    );
    await userEvent.click(screen.getByRole("button", { name: "Delete run" }));
    expect(await screen.findByText("Another page")).toBeVisible();
    expect(screen.getByText(/^Wide deleted\./)).toBeVisible();
    await userEvent.click(screen.getByRole("button", { name: "Undo" }));
    await waitFor(() => expect(asked.at(-1)?.path).toBe(`/api/runs/${one.id}/restore`));
  });

  it("can be run again with changes", () => {
    const parent = "abcdef00-0000-4000-8000-000000000000";
    const one = run({ status: "done", steps: 500_000, training_seed: 3, parent_run_id: parent });
    open(one);
    expect(screen.getByRole("link", { name: "Run again" })).toHaveAttribute(
      "href",
      `/behaviours/1/train?recipe=fast&steps=500000&seed=3&rate=0.0003&continue=${parent}`,
    );
  });
});

describe("name and notes of a run", () => {
  it("head its page and its title", () => {
    open(run({ name: "Wide network", notes: "Twice as wide." }));
    expect(screen.getByRole("heading", { name: "Wide network" })).toBeVisible();
    expect(screen.getByText("Run 3f2a9c")).toBeVisible();
    expect(screen.getByText("Twice as wide.")).toBeVisible();
    expect(document.title).toBe("Wide network · Column 1 · Tril");
  });

  it("are edited in a dialog that says what is refused", async () => {
    const one = run({ status: "done" });
    const sent: unknown[] = [];
    const refusal = {
      detail: "Name can have at most 80 characters.",
      errors: [{ where: ["body", "name"], what: "Name can have at most 80 characters." }],
    };
    open(
      one,
      {},
      {
        [`PATCH /api/runs/${one.id}`]: ({ body }) => {
          sent.push(body);
          return sent.length === 1 ? new Refusal(422, refusal) : { ...one, name: "Wide" };
        },
      },
    );
    await userEvent.click(screen.getByRole("button", { name: "Edit name and notes" }));
    await userEvent.type(screen.getByLabelText("Name"), " Wide ");
    await userEvent.type(screen.getByLabelText("Notes"), "Twice as wide.");
    await userEvent.click(screen.getByRole("button", { name: "Save" }));
    expect(await screen.findByText(refusal.detail)).toBeVisible();
    expect(screen.getByLabelText("Name")).toBeInvalid();
    await userEvent.click(screen.getByRole("button", { name: "Save" }));
    await waitFor(() => expect(screen.queryByRole("dialog")).not.toBeInTheDocument());
    expect(sent.at(-1)).toEqual({ name: "Wide", notes: "Twice as wide." });
  });
});

describe("the results", () => {
  const one = run({ status: "done" });
  const best = recording({ id: 12, source: "scripted", player: null });
  const imitator = game({ recording: recording({ id: 20, source: "policy", targets: 2 }) });
  const clone = game({
    policy: "clone",
    recording: recording({ id: 21, source: "policy", targets: 1, strays: 3, end: "hit" }),
  });
  const results: Partial<RunResults> = {
    summaries: [
      { policy: "imitator", action_selection: "greedy", summary: SUMMARY },
      { policy: "clone", action_selection: "greedy", summary: { ...SUMMARY, targets: null } },
    ],
    comparison: [{ start_number: 0, held_out: false, imitator, clone, winner: "imitator" }],
    further_comparison: [
      {
        start_number: 3,
        held_out: true,
        imitator: game({ start_number: 3 }),
        clone: game({ start_number: 3, policy: "clone" }),
        winner: "tie",
      },
    ],
    games: [imitator, game({ start_number: 3 }), game({ start_number: 3, policy: "clone" })],
    best_demonstration: best,
    check: {
      tau: 0.92,
      pair_accuracy: 0.984,
      held_out_accuracy: 0.91,
      passed: true,
      advice: "",
      warning: "",
      wanted: {
        labels: Array.from(
          { length: 36 },
          (_, index) => [1, -0.9, 0.9][index] ?? (index === 8 ? 0.2 : -0.95),
        ),
        in_order: Array.from({ length: 36 }, (_, index) => (index === 2 ? 1 : 0)),
      },
      statements: [],
      answers: [],
      confused: [
        {
          better_tier: 1,
          worse_tier: 2,
          held_out: false,
          better: [12],
          worse: [11],
          n_right: 0,
          n_compared: 1,
        },
      ],
      returns: [
        { tier: 1, recording: best, predicted_return: 5, final_level: null },
        { tier: 2, recording: recording({ id: 11 }), predicted_return: 7, final_level: null },
      ],
    },
    attention: [
      {
        state: "maximum",
        reward: 3.65,
        recording_id: 12,
        step: 248,
        faithfulness: {
          map: { deletion: 0.81, insertion: 0.22, hidden_fifth: 0.8 },
          random: { deletion: 0.45, insertion: 0.47, hidden_fifth: 0.12 },
        },
        frame_url: "/f.png",
        map_url: "/m.png",
        red_blue_url: "/rb.png",
      },
    ],
    percentiles: Array.from({ length: 101 }, (_, percentile) => ({
      reward: percentile / 10,
      recording_id: percentile < 90 ? 11 : 12,
      step: percentile * 2,
    })),
    artifacts: [
      {
        id: 1,
        kind: "imitator",
        name: "imitator.zip",
        media_type: "application/zip",
        size_bytes: 3_700_000,
        url: "/api/artifacts/1",
      },
    ],
  };

  it("have intervals", async () => {
    open(one, results, {}, "#result");
    const table = within(await screen.findByRole("table", { name: "Imitator and clone" }));
    const row = table.getByRole("row", { name: /Targets hit, of 2/ });
    expect(row).toHaveTextContent("4.73.9 to 5.4–");
    expect(table.getByRole("row", { name: /Death rate/ })).toHaveTextContent("13%0% to 30%");
    expect(screen.getByText(/Means of 23 games/)).toBeVisible();
  });

  it("are shown for every way of playing that was played", async () => {
    const sticky = { ...SUMMARY, targets: { mean: 3.1, low: 2.5, high: 3.7, n: 23 } };
    open(
      one,
      {
        ...results,
        summaries: [
          ...(results.summaries ?? []),
          { policy: "imitator", action_selection: "sticky", summary: sticky },
        ],
      },
      {},
      "#result",
    );
    await userEvent.click(await screen.findByText("With sticky actions"));
    expect(screen.getByText(/repeated with probability 25%/)).toBeVisible();
    const table = within(
      screen.getByRole("table", { name: "Imitator and clone, with sticky actions" }),
    );
    expect(table.getByRole("row", { name: /Targets hit, of 2/ })).toHaveTextContent(
      "3.12.5 to 3.7",
    );
    // An earlier version's run may lack some.
    expect(screen.queryByText("With sampled actions")).not.toBeInTheDocument();
  });

  it("set the games of a start side by side, below the best demonstration", async () => {
    open(one, results, {}, "#games");
    const table = within(await screen.findByRole("table", { name: "Games from the first starts" }));
    expect(table.getByRole("button", { name: /^Watch imitator from start 0/ })).toBeVisible();
    expect(table.getByRole("button", { name: /^Watch clone from start 0/ })).toHaveTextContent(
      "1 target, 3 strayshit by a bomb",
    );
    expect(table.getByRole("columnheader", { name: "Imitator against clone" })).toBeVisible();
    expect(screen.getAllByRole("button", { name: /^Watch best demonstration/ })).toHaveLength(1);
    expect(table.getByText("seen in training")).toBeVisible();
    expect(screen.getByText("1 further start")).toBeVisible();
  });

  it("have no column for the better game where none is known to be better", async () => {
    const undecided = (rows: RunResults["comparison"] = []) =>
      rows.map((row) => ({ ...row, winner: null }));
    open(
      one,
      {
        ...results,
        comparison: undecided(results.comparison),
        further_comparison: undecided(results.further_comparison),
      },
      {},
      "#games",
    );
    const table = within(await screen.findByRole("table", { name: "Games from the first starts" }));
    expect(table.getAllByRole("columnheader").map((cell) => cell.textContent)).toEqual([
      "Start",
      "Imitator",
      "Clone",
    ]);
    expect(screen.queryByText("Imitator against clone")).toBeNull();
  });

  it("fold the games of all starts on a phone", async () => {
    vi.stubGlobal("matchMedia", (query: string) =>
      Object.assign(new EventTarget(), { media: query, matches: query.includes("max-width") }),
    );
    open(one, results, {}, "#games");
    const summary = await screen.findByText("Games from 2 starts");
    const game = () => screen.getByRole("button", { name: /^Watch imitator from start 3/ });
    expect(game()).not.toBeVisible();
    await userEvent.click(summary);
    expect(game()).toBeVisible();
  });

  it("show which aliens the reward wants, and which it is not sure of", async () => {
    open(one, results, {}, "#check");
    const wanted = within(await screen.findByRole("region", { name: "What the reward wants" }));
    const names = "row 1, column 1; row 1, column 3; row 2, column 3";
    const missed = "row 2, column 1";
    expect(
      wanted.getByRole("img", {
        name: `To be hit: ${names}. Targets among the others: ${missed}. Not sure: row 2, column 3`,
      }),
    ).toBeVisible();
    expect(wanted.getByText(/^Unsure about 1 alien \(dashed\)/)).toBeVisible();
    expect(wanted.getByText(/^1 target \(outlined\) is not learned/)).toBeVisible();
    expect(wanted.getByText(/^1 other alien seems wanted/)).toBeVisible();
    expect(
      wanted.getByText("In row 1, a wanted alien counts only once all on its left are gone."),
    ).toBeVisible();
  });

  it("say what the order is about where the reward is a statement", async () => {
    const statements = [
      statement("what you steer further to the left", 0.83),
      statement("FIRE held less", 0.09),
    ];
    const answers = [{ subjects: ["button 0 held"], sentence: "FIRE held less", meant: false }];
    const check = results.check && { ...results.check, wanted: null, statements, answers };
    open(one, { ...results, check: check ?? null });

    const told = within(await screen.findByRole("region", { name: /^What Tril understood/ }));
    expect(told.getAllByRole("listitem").map((item) => item.textContent)).toEqual([
      "what you steer further to the left83%",
      "FIRE held less9%",
      "You said that it is not this: FIRE held less",
    ]);
  });

  it("say nothing of wanted aliens where the reward was learned otherwise", async () => {
    const check = results.check && { ...results.check, wanted: null };
    open(one, { ...results, check: check ?? null }, {}, "#check");
    await screen.findByRole("table", { name: "Ranked games by the reward" });
    expect(screen.queryByRole("region", { name: "What the reward wants" })).toBeNull();
  });

  it("set predicted returns against tiers and mark what is out of order", async () => {
    open(one, results, {}, "#check");
    const table = within(await screen.findByRole("table", { name: "Ranked games by the reward" }));
    const rows = table
      .getAllByRole("row")
      .slice(1)
      .map((row) => row.textContent);
    expect(rows).toEqual(["1Recording 12scripted5.00", "2Recording 11Ada7.00 (highest)"]);
    const check = within(
      screen.getByRole("region", { name: "Does the reward agree with the ranking?" }),
    );
    expect(check.getByText("0.92")).toBeVisible();
    expect(check.getByText("98.4%")).toBeVisible();
    expect(screen.getByText(/^Recording 12 above Recording 11: right in 0 of 1/)).toBeVisible();
  });

  it("warn of a reward that does not follow the ranking everywhere", async () => {
    const check = results.check && { ...results.check, warning: "It can’t tell 1 and 2 apart." };
    open(one, { ...results, check: check ?? null });
    const warning = await screen.findByText(/It can’t tell 1 and 2 apart/);
    expect(within(warning).getByRole("link", { name: "See which recordings" })).toHaveAttribute(
      "href",
      "/#check",
    );
  });

  it("say whether the reward orders all recordings as they are ranked", async () => {
    open(one, results, {}, "#check");
    expect(await screen.findByText(/^The learned reward agrees with most/)).toBeVisible();
    cleanup();
    const check = results.check && { ...results.check, confused: [] };
    open(one, { ...results, check: check ?? null }, {}, "#check");
    expect(
      await screen.findByText("The learned reward orders the recordings as they are ranked."),
    ).toBeVisible();
  });

  it("judge ranked games by the levels that they end at", async () => {
    const levels = [0.91, 0.42];
    const returns = results.check?.returns.map((row, i) => ({
      ...row,
      final_level: levels[i] ?? 0,
    }));
    const check = results.check && { ...results.check, returns: returns ?? [] };
    open(one, { ...results, check: check ?? null }, {}, "#check");
    const plot = await screen.findByRole("img", { name: "Final level by tier" });
    expect(plot).toHaveTextContent("Recording 12, tier 1: 0.91");
    const table = screen.getByRole("table", { name: "Ranked games by the reward" });
    const rows = within(table)
      .getAllByRole("row")
      .slice(1)
      .map((row) => row.textContent);
    expect(rows).toEqual(["1Recording 12scripted0.91", "2Recording 11Ada0.42"]);
  });

  it("set what the reward predicts against what games were worth", async () => {
    const played = [
      { true_quantity: 6, predicted: 0.97, recording_id: 20 },
      { true_quantity: 5, predicted: 0.8, recording_id: 22 },
    ];
    const measure = "final_level" as const;
    open(
      one,
      {
        ...results,
        judged: [
          {
            player: "demonstrator",
            demonstrated: true,
            measure,
            tau: 0.97,
            games: [
              { true_quantity: -13, predicted: -2.35, recording_id: 11 },
              { true_quantity: 6, predicted: 1.02, recording_id: 12 },
            ],
          },
          { player: "imitator", demonstrated: false, measure, tau: null, games: played },
        ],
      },
      {},
      "#extrapolation",
    );
    const plot = await screen.findByRole("img", { name: /Final level by targets hit/ });
    expect(plot).toHaveTextContent("Imitator, worth 5: 0.80");
    const table = screen.getByRole("table", {
      name: "Predicted and actual worth of games",
    });
    const rows = within(table)
      .getAllByRole("row")
      .slice(1)
      .map((row) => row.textContent);
    expect(rows).toEqual([
      "Demonstratorlearned from2−13 to 6−2.35 to 1.020.97",
      "Imitatornever seen25 to 60.80 to 0.97–",
    ]);
    expect(screen.getByText(/Beyond the shaded range/)).toBeVisible();
  });

  it("show attention in either colour map", async () => {
    open(one, results, {}, "#attention");
    const map = await screen.findByRole("img", { name: "Attention map at the maximum of R" });
    expect(map).toHaveAttribute("src", "/m.png");
    await userEvent.click(screen.getByRole("radio", { name: "Red-blue" }));
    expect(map).toHaveAttribute("src", "/rb.png");
    expect(
      screen.getByText(
        /brightest fifth of the pixels, and R changes by 80% .* random fifth, and it changes by 12%/,
      ),
    ).toBeVisible();
    expect(screen.getByText("Deletion 0.81 (0.45), insertion 0.22 (0.47)")).toBeVisible();
    expect(screen.getByRole("button", { name: "Watch Recording 12 from step 248" })).toBeVisible();
  });

  it("lead to the state at any percentile of R, and to those of the maps", async () => {
    const routes = {
      "GET /api/recordings/12/frames": () => framesFile(8),
      [`GET /api/runs/${one.id}/reward/12`]: () => ({
        run_id: one.id,
        recording_id: 12,
        rewards: [0, 10],
        levels: [0, 1],
        zero_level_reward: 0,
        unit_level_reward: 10,
        reward_deviations: null,
        level_deviations: null,
      }),
    };
    open(one, results, routes, "#attention");
    const any = within(await screen.findByRole("region", { name: "Any percentile of R" }));
    const slider = any.getByRole("slider", { name: "Any percentile of R" });
    await waitFor(() =>
      expect(slider).toHaveAttribute("aria-valuetext", "75th percentile, R 0.75"),
    );
    fireEvent.change(slider, { target: { value: "93" } });
    expect(slider).toHaveAttribute("aria-valuetext", "93rd percentile, R 0.93");
    expect(any.getByText("Recording 12, step 186")).toBeVisible();
    expect(
      await any.findByRole("img", { name: "Screen at step 186 of Recording 12" }),
    ).toBeVisible();
    expect(any.getByRole("link", { name: "Open this moment" })).toHaveAttribute(
      "href",
      `/recordings/12?step=186&run=${one.id}`,
    );
    expect(screen.getByRole("link", { name: "Recording 12, step 248" })).toHaveAttribute(
      "href",
      `/recordings/12?step=248&run=${one.id}`,
    );
  });

  it("can be downloaded", async () => {
    open(one, results, {}, "#files");
    const file = await screen.findByRole("link", { name: "imitator.zip" });
    expect(file).toHaveAttribute("href", "/api/artifacts/1");
    expect(screen.getByText("3.7 MB")).toBeVisible();
  });
});

describe("teaching more", () => {
  const one = run({ status: "cancelled", parent_run_id: "abcdef00-0000-4000-8000-000000000000" });
  const good = recording({ id: 20, run_id: one.id, source: "policy", targets: 2 });
  const bad = recording({ id: 21, run_id: one.id, source: "policy", strays: 3, end: "hit" });
  const imitator = {
    id: 1,
    kind: "imitator",
    name: "imitator.zip",
    media_type: "application/zip",
    size_bytes: 1,
    url: "/api/artifacts/1",
  };
  const taught: Partial<RunResults> = {
    comparison: [
      {
        start_number: 0,
        held_out: true,
        imitator: game({ recording: good }),
        clone: null,
        winner: null,
      },
    ],
    games: [
      game({ recording: good }),
      game({ recording: bad, action_selection: "sticky", start_number: 7 }),
    ],
    proposed: [20, 21],
    artifacts: [imitator],
  };

  /** Serves a ranking's games that requests change; one of them can be ranked already. */
  function openTaught(change: Partial<RunResults> = {}, ranked = false, of = one) {
    let held: Recording[] = ranked ? [{ ...good, borrowed: true, ranked }] : [];
    const asked = serve({
      [`GET /api/runs/${one.id}/results`]: () => results(of, { ...taught, ...change }),
      [`GET /api/runs/${one.id}/metrics`]: () => ({ last: 0, series: {} }),
      "GET /api/behaviours/1/borrowed": () => libraryOf(held),
      "POST /api/behaviours/1/ranking/games": ({ body }) => {
        const { recording_ids: ids } = body as { recording_ids: number[] };
        held = [...held, ...[good, bad].filter(({ id }) => ids.includes(id))];
        return held;
      },
      "DELETE /api/behaviours/1/borrowed/20": () => {
        held = held.filter(({ id }) => id !== 20);
        return undefined;
      },
    });
    return { asked, ...show(<RunPage run={of} behaviour={behaviour()} />, "/#teach") };
  }

  const games = async () => within(await screen.findByRole("list", { name: "Games to rank" }));

  it("proposes games that differ, with what became of them", async () => {
    openTaught();
    const shown = (await games()).getAllByRole("listitem").map((item) => item.textContent);
    expect(shown[0]).toContain("2 of 2 targets, no strays");
    expect(screen.getByText(/^These games of the imitator differ most/)).toBeVisible();
    expect(shown[1]).toContain("3 strayshit by a bombsticky actions, start 7");
    await userEvent.click(
      screen.getByRole("button", { name: "Watch imitator, sticky actions, start 7" }),
    );
    const dialog = within(screen.getByRole("dialog"));
    expect(
      await dialog.findByRole("button", { name: "Add to the ranking: Recording 21" }),
    ).toBeVisible();
  });

  it("says that flawless games teach hardly anything, and lets them be ranked", async () => {
    openTaught({ proposed: [20] });
    expect(await screen.findByText(/^These games of the imitator are flawless/)).toBeVisible();
    expect(screen.queryByText(/differ most/)).toBeNull();
    expect(await screen.findByRole("button", { name: "Add 1 game and rank it" })).toBeVisible();
  });

  it("adds a game to the ranking's games, wherever it is shown, and gives it back", async () => {
    const { asked } = openTaught();
    const list = await games();
    await userEvent.click(
      await list.findByRole("button", { name: "Add to the ranking: Recording 20" }),
    );
    const inRanking = { name: "In the ranking’s games: Recording 20. Give it back" };
    expect(await list.findByRole("button", inRanking)).toHaveAttribute("aria-pressed", "true");
    await userEvent.click(screen.getByRole("heading", { name: "How did each game go?" }));
    const table = within(screen.getByRole("table", { name: "Games from the first starts" }));
    await userEvent.click(table.getByRole("button", inRanking));
    expect(
      await table.findByRole("button", { name: "Add to the ranking: Recording 20" }),
    ).toBeVisible();
    expect(asked.filter(({ method }) => method !== "GET").map(({ method }) => method)).toEqual([
      "POST",
      "DELETE",
    ]);
  });

  it("adds those that are missing at once and leads to the ranking", async () => {
    const { asked, router } = openTaught({}, true);
    const ranked = await screen.findAllByRole("button", { name: /^Ranked: Recording 20/ });
    for (const button of ranked) expect(button).toHaveAttribute("aria-disabled", "true");
    await userEvent.click(screen.getByRole("button", { name: "Add 1 game and rank it" }));
    await waitFor(() => expect(router.state.location.pathname).toBe("/behaviours/1/rank"));
    expect(router.state.location.search).toBe(`?continue=${one.id}`);
    expect(asked.find(({ method }) => method === "POST")?.body).toEqual({ recording_ids: [21] });
  });

  it("leads to placing by comparing once some are among the unranked", async () => {
    openTaught();
    const list = await games();
    const compare = { name: "Place by comparing" };
    const add = await list.findByRole("button", { name: "Add to the ranking: Recording 20" });
    expect(screen.queryByRole("link", compare)).toBeNull();
    await userEvent.click(add);
    expect(await screen.findByRole("link", compare)).toHaveAttribute(
      "href",
      `/behaviours/1/rank?continue=${one.id}&compare`,
    );
  });

  it("trains the imitator further, even if there are no games yet", async () => {
    openTaught({ proposed: [], games: [], comparison: [] });
    const further = await screen.findByRole("link", { name: "Train further from this imitator" });
    expect(further).toHaveAttribute("href", `/behaviours/1/train?continue=${one.id}`);
    expect(screen.queryByRole("list", { name: "Games to rank" })).not.toBeInTheDocument();
  });

  it("needs an imitator, and a run that is over", async () => {
    openTaught({ artifacts: [] });
    expect(await screen.findByRole("heading", { name: "How was it set up?" })).toBeVisible();
    expect(
      screen.queryByRole("heading", { name: "What teaches it more?" }),
    ).not.toBeInTheDocument();
  });

  it("proposes games of a training that still goes on, and to go on with the new order", async () => {
    const learning = run({ ...one, status: "running", steps: 300_000 });
    const training_games = { steps: 100_000, games: [good, bad] };
    openTaught({ proposed: [], games: [], comparison: [], training_games }, false, learning);
    expect(
      await screen.findByRole("heading", { name: "What teaches it more while it learns?" }),
    ).toBeVisible();
    const shown = (await games()).getAllByRole("listitem").map((item) => item.textContent);
    expect(shown[1]).toContain("after 100,000 steps");
    expect(screen.getByRole("link", { name: "Go on with the new order" })).toHaveAttribute(
      "href",
      `/behaviours/1/train?continue=${one.id}&steps=200000`,
    );
    expect(screen.getByRole("button", { name: "Add 2 games and rank them" })).toBeVisible();
  });

  it("says which run another one continues", async () => {
    openTaught();
    expect(screen.getByRole("link", { name: "Run abcdef" })).toHaveAttribute(
      "href",
      "/runs/abcdef00-0000-4000-8000-000000000000",
    );
    expect(await screen.findByRole("heading", { name: "What teaches it more?" })).toBeVisible();
  });
});

describe("the list of runs", () => {
  it("sets parameters and results side by side", async () => {
    const shown = headline({
      imitator: SUMMARY,
      tau: 0.98,
    });
    serve({
      "GET /api/runs": () => [
        run({
          status: "done",
          headline: shown,
          finished_at: "2026-01-01T12:17:01Z",
        }),
        run({ id: "ffff0000-0000-4000-8000-000000000000", example: true }),
      ],
    });
    show(<RunsPage behaviour={behaviour()} />);
    const done = await screen.findByRole("row", { name: /Run 3f2a9c/ });
    expect(done).toHaveTextContent("4.73.9 to 5.4");
    expect(done).toHaveTextContent("17 min");
    const going = screen.getByRole("row", { name: /Run ffff00/ });
    expect(going).toHaveTextContent("Imitator, 60%, about 2 min left");
    expect(going).toHaveTextContent("scripted example");
  });

  it("leads to training where there is none", async () => {
    serve({ "GET /api/runs": () => [] });
    show(<RunsPage behaviour={behaviour()} />);
    expect(await screen.findByRole("link", { name: "Go to Train" })).toHaveAttribute(
      "href",
      "/behaviours/1/train",
    );
  });
});
