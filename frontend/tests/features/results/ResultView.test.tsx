import { act, fireEvent, screen, waitFor, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { describe, expect, it, vi } from "vitest";

import type { Behaviour, PolicySummary, RunResults, StatementAnswer } from "@/api/types";
import { figuresOf } from "@/features/results/result/figures";
import { ResultView } from "@/features/results/result/ResultView";

import { behaviour, game, headline, recording, results, run, statement } from "../../support/data";
import { framesFile } from "../../support/frames";
import { SPACE_INVADERS } from "../../support/games";
import { show } from "../../support/page";
import { type Asked, Refusal, serve } from "../../support/server";

const ONE = run({ status: "done" });
const BEST = recording({ id: 12, n_frames: 16, start: { idle_frames: 70 } });
const NEAR = game({
  start_number: 7,
  recording: recording({ id: 20, source: "policy", run_id: ONE.id, start: { idle_frames: 68 } }),
});
const FAR = game({
  recording: recording({ id: 21, source: "policy", run_id: ONE.id, start: { idle_frames: 10 } }),
});
const GAMES: Partial<RunResults> = {
  games: [FAR, NEAR],
  shown_game: 20,
  best_demonstration: BEST,
};
const SUMMARY: PolicySummary = {
  targets: { mean: 4.7, low: 3.9, high: 5.4, n: 23 },
  strays: { mean: 0.2, low: 0, high: 0.5, n: 23 },
  order_errors: null,
  steps: { mean: 288, low: 270, high: 300, n: 23 },
  death_rate: { mean: 0.13, low: 0, high: 0.3, n: 23 },
  predicted_return: { mean: 3, low: 1, high: 4, n: 23 },
};
const CHECK: NonNullable<RunResults["check"]> = {
  tau: 0.92,
  pair_accuracy: 0.98,
  held_out_accuracy: null,
  passed: true,
  advice: "",
  warning: "",
  wanted: null,
  statements: [statement("what you steer further to the left", 0.83)],
  answers: [],
  confused: [],
  returns: [],
};

/** R rises from 0 to `end` over the steps of a game. */
function trace(id: number, nSteps: number, end: number) {
  const levels = Array.from({ length: nSteps + 1 }, (_, step) => (end * step) / nSteps);
  return {
    run_id: ONE.id,
    recording_id: id,
    rewards: levels,
    levels,
    reward_deviations: null,
    level_deviations: null,
  };
}

function open(change: Partial<RunResults> = {}, of: Behaviour = behaviour(), more = {}) {
  const asked = serve({
    "GET /api/recordings/12/frames": () => framesFile(16),
    "GET /api/recordings/20/frames": () => framesFile(24),
    [`GET /api/runs/${ONE.id}/reward/12`]: () => trace(12, 4, 1),
    [`GET /api/runs/${ONE.id}/reward/20`]: () => trace(20, 6, 0.6),
    ...more,
  });
  show(<ResultView run={ONE} results={results(ONE, { ...GAMES, ...change })} behaviour={of} />);
  return asked;
}

/** Lets the system ask for less motion. */
function calm() {
  const list = (query: string) =>
    Object.assign(new EventTarget(), { matches: query.includes("reduce"), media: query });
  vi.stubGlobal("matchMedia", list);
}

describe("the games of a result", () => {
  it("play at once and in step, with R of both under them", async () => {
    open();
    const position = await screen.findByRole<HTMLInputElement>("slider", {
      name: "Position in the recording",
    });
    // It ends by itself, where the longer game does.
    await waitFor(() => expect(position.valueAsNumber).toBe(24));
    for (const name of ["imitator", "person, best game"]) {
      expect(screen.getByRole("img", { name: `Game screen of ${name}` })).toBeVisible();
    }
    const curve = await screen.findByRole("slider", { name: "Position on the curve of R" });
    fireEvent.change(position, { target: { value: "12" } });
    expect(curve).toHaveAttribute(
      "aria-valuetext",
      "step 3, Imitator 0.30, Person, best game 0.75",
    );
    // The shorter game stays as it ended.
    fireEvent.change(position, { target: { value: "24" } });
    expect(curve).toHaveAttribute(
      "aria-valuetext",
      "step 6, Imitator 0.60, Person, best game 1.00",
    );
  });

  it("wait at their ends where the system asks for less motion, and move by keys", async () => {
    calm();
    open();
    expect(await screen.findByRole("button", { name: "Play" })).toBeVisible();
    const position = screen.getByRole<HTMLInputElement>("slider", {
      name: "Position in the recording",
    });
    expect(position.valueAsNumber).toBe(24);
    act(() => position.focus());
    await userEvent.keyboard("{Shift>}{ArrowLeft}{/Shift}");
    expect(position.valueAsNumber).toBe(20);
    await userEvent.keyboard("{Home}");
    expect(position.valueAsNumber).toBe(0);
  });

  it("play without R where no network answers, and say why", async () => {
    const away = () => new Refusal(503, { detail: "The inference process is not running." });
    open({}, behaviour(), { [`GET /api/runs/${ONE.id}/reward/20`]: away });
    expect(
      await screen.findByText(/^R over time can’t be shown: The inference process/),
    ).toBeVisible();
    expect(screen.getByRole("img", { name: "Game screen of imitator" })).toBeVisible();
  });

  it("are the imitator's alone where there is no demonstration", async () => {
    open({ games: [NEAR], best_demonstration: null });
    expect(await screen.findByRole("img", { name: "Game screen of imitator" })).toBeVisible();
    expect(screen.queryByRole("img", { name: /best game/ })).toBeNull();
  });

  it("are asked for only once the imitator has played", async () => {
    const asked = open({ games: [], check: CHECK });
    expect(await screen.findByText(/Is this what you meant/)).toBeVisible();
    expect(asked.filter(({ path }) => path.endsWith("frames"))).toEqual([]);
  });
});

describe("the verdict on a result", () => {
  const verdict = {
    tone: "good",
    sentence: "The imitator hits 6 of 6 targets.",
    details: "It loses no game.",
    advice: "Watch some of its games.",
    next_step: "games",
  } as const;

  it("is one sentence over the games, with what to do next before them", async () => {
    open({ verdict });
    const games = await screen.findByRole("group", { name: "Games in step" });
    const said = screen.getByRole("region", { name: "Verdict" });
    expect(said).toHaveTextContent(/^The imitator hits 6 of 6 targets\.$/);
    const next = screen.getByRole("region", { name: "What to do next" });
    expect(next).toHaveTextContent("It loses no game.Watch some of its games.");
    const { DOCUMENT_POSITION_FOLLOWING: follows } = Node;
    expect(said.compareDocumentPosition(next) & follows).toBeTruthy();
    expect(next.compareDocumentPosition(games) & follows).toBeTruthy();
  });

  it("is left to the page where there are no games to stand over", () => {
    open({ verdict, games: [] });
    expect(screen.queryByRole("region", { name: "Verdict" })).toBeNull();
  });
});

describe("what a result says", () => {
  it("has the picture of what was understood", async () => {
    const pictured = statement("what you steer further to the left", 0.83, {
      pictures: ["/thing.png"],
    });
    open({ check: { ...CHECK, statements: [pictured] } });
    const told = await screen.findByRole("region", { name: /^What Tril understood/ });
    expect(told.querySelector("img")).toHaveAttribute("src", "/thing.png");
  });

  it("is what was understood, and asks whether it was meant", async () => {
    open({ check: CHECK });
    const told = within(await screen.findByRole("region", { name: /^What Tril understood/ }));
    expect(told.getByRole("listitem")).toHaveTextContent("what you steer further to the left83%");
    expect(screen.getByRole("link", { name: "Answer under Rank" })).toHaveAttribute(
      "href",
      "/behaviours/1/rank",
    );
  });

  it("is answered there, and offers to train again with what is answered", async () => {
    const LEFT = "what you steer further to the left";
    const told = [
      statement(LEFT, 0.83, { subjects: ["thing 12:8-8x9-9 x"] }),
      statement("FIRE held less", 0.09, { subjects: ["button 0 held"] }),
    ];
    let answers: StatementAnswer[] = [];
    const asked = open({ check: { ...CHECK, statements: told } }, behaviour(), {
      "GET /api/behaviours/1/ranking/answers": () => answers,
      "PUT /api/behaviours/1/ranking/answers": ({ body }: Asked) => {
        const { meant, ...given } = body as Omit<StatementAnswer, "meant"> & {
          meant: boolean | null;
        };
        answers = meant === null ? [] : [{ ...given, meant }];
        return answers;
      },
    });
    await userEvent.click(await screen.findByRole("button", { name: `This is it: ${LEFT}` }));
    expect(await screen.findByText("You said: this is it.")).toBeVisible();
    expect(asked.find(({ method }) => method === "PUT")?.body).toEqual({
      subjects: ["thing 12:8-8x9-9 x"],
      sentence: LEFT,
      meant: true,
    });
    const again = screen.getByRole("link", { name: "Train again with this answer" });
    expect(again.getAttribute("href")).toMatch(/^\/behaviours\/1\/train\?recipe=/);

    const back = screen.getByRole("button", { name: `Take back: ${LEFT}` });
    await waitFor(() => expect(back).toHaveAttribute("aria-disabled", "false"));
    await userEvent.click(back);
    expect(await screen.findByText(/Is this what you meant/)).toBeVisible();
    expect(screen.queryByRole("link", { name: /Train again/ })).toBeNull();

    const not = screen.getByRole("button", { name: `Not this: ${LEFT}` });
    await waitFor(() => expect(not).toHaveAttribute("aria-disabled", "false"));
    await userEvent.click(not);
    expect(await screen.findByText("You said: not this.")).toBeVisible();
    expect(screen.getByRole("heading", { name: /^What Tril understood/ })).toHaveFocus();
  });

  it("offers to train again without what was taken back, and nothing where the run was told", async () => {
    const subjects = ["button 0 held"];
    const known = [{ subjects, sentence: "FIRE held less", meant: true }];
    let answers: StatementAnswer[] = known;
    const statements = [statement("FIRE held less", 0.9, { subjects })];
    open({ check: { ...CHECK, statements, answers: known } }, behaviour(), {
      "GET /api/behaviours/1/ranking/answers": () => answers,
      "PUT /api/behaviours/1/ranking/answers": () => (answers = []),
    });
    expect(await screen.findByText("You said: this is it.")).toBeVisible();
    expect(screen.queryByRole("link", { name: /Train again/ })).toBeNull();
    await userEvent.click(screen.getByRole("button", { name: "Take back: FIRE held less" }));
    expect(await screen.findByRole("link", { name: "Train again without it" })).toBeVisible();
  });

  it("asks nothing where the reward is no statement", async () => {
    open({ check: { ...CHECK, statements: [] } });
    await screen.findByRole("group", { name: "Games in step" });
    expect(screen.queryByText(/Is this what you meant/)).toBeNull();
  });

  it("has at most five figures, each beside the clone's", async () => {
    const summary = { ...SUMMARY, perfect: { mean: 0.4, low: 0.2, high: 0.6, n: 23 } };
    open({
      check: CHECK,
      summaries: [
        { policy: "imitator", action_selection: "greedy", summary },
        {
          policy: "clone",
          action_selection: "greedy",
          summary: { ...SUMMARY, targets: { mean: 2.3, low: 2, high: 3, n: 23 } },
        },
      ],
    });
    await waitFor(() => expect(screen.getAllByRole("term")).toHaveLength(5));
    const [first] = screen.getAllByRole("term");
    expect(first?.parentElement).toHaveTextContent("Targets hit, of 24.7Clone 2.3");
  });

  it("has the behaviour's measures first where there is no target", () => {
    const free = behaviour({ target: null, measures: [{ kind: "score", at_least: 10 }] });
    const mean = { mean: 12, n: 20, n_met: 18 };
    const summary = { ...SUMMARY, targets: null, strays: null };
    const figures = figuresOf(
      results(ONE, {
        check: CHECK,
        measures: [
          {
            measure: { kind: "score", at_least: 10 },
            unit: "points",
            imitator: mean,
            clone: null,
            person: { ...mean, mean: 15 },
          },
        ],
        summaries: [{ policy: "imitator", action_selection: "greedy", summary }],
      }),
      free,
      SPACE_INVADERS,
    );
    expect(figures.map(({ name, value }) => `${name} ${value}`)).toEqual([
      "Score: at least 10 12.0",
      "Game length, of 300 steps 288.0",
      "Death rate 13%",
      "Agreement of R with the ranking, 1 at most 0.92",
    ]);
    expect(figures[0]?.others).toEqual([
      { actor: "person", text: "15.0 in all ranked games", interval: null },
    ]);
  });

  it("writes a share of the time in no more room than a figure has", () => {
    const measure = { kind: "rate", button: "left", per: "time", at_least: 0.9 } as const;
    const mean = (value: number) => ({ mean: value, n: 23, n_met: 20 });
    const shown = results(ONE, {
      measures: [
        { measure, unit: "share", imitator: mean(0.98), clone: mean(0.9), person: mean(0.68) },
      ],
    });
    const [first] = figuresOf(shown, behaviour({ target: null }), SPACE_INVADERS);
    expect(first?.name).toMatch(/held: at least 90% of the time$/);
    expect(first?.value).toBe("98%");
    expect(first?.others.map(({ text }) => text)).toEqual(["90%", "68% in all ranked games"]);
  });

  it("has what Tril understood first where nothing measures the behaviour", () => {
    const share = (mean: number) => ({ mean, low: mean - 0.1, high: mean + 0.1, n: 23 });
    const understood = {
      imitator: share(0.88),
      clone: share(-0.02),
      best: share(0.31),
      read: null,
    };
    const elsewhere = { imitator: share(0.42), clone: null, best: null };
    const understoodRun = run({ ...ONE, headline: headline({ understood, elsewhere }) });
    const shown = results(understoodRun, { check: CHECK });
    const [first, second] = figuresOf(shown, behaviour({ target: null }), SPACE_INVADERS);
    expect(first).toEqual({
      name: "Worth by what Tril understood (100%: a full game)",
      value: "88%",
      others: [
        { actor: "clone", text: "0%", interval: share(-0.02) },
        { actor: "person", text: "31% in the best games", interval: share(0.31) },
      ],
      plot: { interval: share(0.88), low: 0, high: 1 },
    });
    expect(second).toMatchObject({
      name: "Time spent elsewhere than the best games, while they last",
      value: "42%",
      others: [],
    });
    expect(figuresOf(shown, behaviour(), SPACE_INVADERS)[0]?.name).not.toMatch(/understood/);
  });

  it("has the blind comparison first where nothing measures the behaviour, else second", () => {
    const blind = {
      wins: 6.5,
      share: { mean: 0.65, low: 0.35, high: 0.86, n: 10 },
      against: [
        { opponent: "clone" as const, wins: 4.5, n: 5 },
        { opponent: "person" as const, wins: 2, n: 5 },
      ],
      n_people: 1,
    };
    const shown = results(ONE, {
      blind,
      summaries: [{ policy: "imitator", action_selection: "greedy", summary: SUMMARY }],
    });
    const [first] = figuresOf(shown, behaviour({ target: null }), SPACE_INVADERS);
    expect(first).toMatchObject({
      name: "Closer to what was meant (blind comparison)",
      value: "65%",
      others: [
        { actor: "clone", text: "0.5 of 5" },
        { actor: "person", text: "3 of 5" },
      ],
      plot: { interval: blind.share, low: 0, high: 1 },
    });
    const measured = figuresOf(shown, behaviour(), SPACE_INVADERS);
    expect(measured.findIndex(({ value }) => value === "65%")).toBe(1);
    expect(measured).toHaveLength(5);
  });
});
