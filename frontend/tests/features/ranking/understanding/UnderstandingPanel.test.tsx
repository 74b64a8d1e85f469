import { screen, waitFor, within } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { useState } from "react";
import { describe, expect, it, vi } from "vitest";

import type { StatementAnswer, Understanding } from "@/api/types";
import { UnderstandingPanel } from "@/features/ranking/understanding/UnderstandingPanel";
import { isReadByStatements } from "@/features/ranking/understanding/use-understanding";

import { KnownRecordings } from "@/features/ranking/recording-names";

import { behaviour, recording, statement as told } from "../../../support/data";
import { show } from "../../../support/page";
import { type Asked, Refusal, serve } from "../../../support/server";

const LEFT = "what you steer further to the left";
const FIRE = "FIRE held less";

function statement(sentence: string, probability: number, subject: string) {
  return told(sentence, probability, { subjects: [subject] });
}

const READY: Understanding = {
  state: "ready",
  progress: 1,
  statements: [
    { ...statement(LEFT, 0.834, "thing 12:8-8x9-9 x"), pictures: ["/thing.png"] },
    statement(FIRE, 0.09, "button 0 held"),
    statement("memory 28 larger", 0.004, "memory 28 value"),
    statement("memory 30 larger", 0.003, "memory 30 value"),
  ],
  is_sense: true,
  values: {},
  contradiction: null,
  next_game: null,
  answers: [],
};

const UNDERSTANDING = "POST /api/behaviours/1/ranking/understanding";

/** A fake server that keeps what is answered; `said` is what it says, each time anew. */
function server(said: () => Partial<Understanding>) {
  let answers: StatementAnswer[] = [];
  return serve({
    [UNDERSTANDING]: () => ({ ...READY, answers, ...said() }),
    "PUT /api/behaviours/1/ranking/answers": ({ body }: Asked) => {
      const { meant, ...given } = body as Omit<StatementAnswer, "meant"> & {
        meant: boolean | null;
      };
      answers = answers.filter(({ subjects }) => subjects.join() !== given.subjects.join());
      if (meant !== null) answers.push({ ...given, meant });
      return answers;
    },
  });
}

function open(said: () => Partial<Understanding> = () => ({}), tiers = [[1], [2]]) {
  const asked = server(said);
  const known = new Map([7, 9].map((id) => [id, recording({ id })]));
  const page = show(
    <KnownRecordings value={known}>
      <UnderstandingPanel behaviourId={1} tiers={tiers} perfect={[1]} />
    </KnownRecordings>,
  );
  return { asked, ...page };
}

/** The panel of an order that is turned round by a button. */
function Turned() {
  const [tiers, setTiers] = useState([[1], [2]]);
  return (
    <>
      <button onClick={() => setTiers(tiers.toReversed())}>Turn round</button>
      <UnderstandingPanel behaviourId={1} tiers={tiers} perfect={[]} />
    </>
  );
}

const panel = () => within(screen.getByRole("region", { name: "What Tril understood" }));

describe("what is understood of an order", () => {
  it("is asked of the order shown and said most likely first, with the thing's picture", async () => {
    const { asked } = open();
    await screen.findByText(LEFT);
    expect(
      panel()
        .getAllByRole("listitem")
        .map((item) => item.textContent),
    ).toEqual([
      `${LEFT}83%This is itNot this`,
      `${FIRE}9%This is itNot this`,
      // Three are shown at least; what is less probable still is not.
      "memory 28 larger0%This is itNot this",
    ]);
    expect(document.querySelector("img")).toHaveAttribute("src", "/thing.png");
    expect(asked.find(({ path }) => path.endsWith("/understanding"))?.body).toEqual({
      tiers: [[1], [2]],
      with_next: false,
    });
    expect(screen.queryByText(/may be chance/)).toBeNull();
  });

  it("stays while a new order is asked about, so that nothing jumps", async () => {
    let answer: (next: Understanding) => void = () => undefined;
    const second = new Promise<Understanding>((resolve) => (answer = resolve));
    let n = 0;
    serve({ [UNDERSTANDING]: () => (n++ === 0 ? READY : second) });
    show(<Turned />);
    await screen.findByText(LEFT);
    await userEvent.click(screen.getByRole("button", { name: "Turn round" }));
    await waitFor(() => expect(n).toBe(2));
    expect(screen.getByText(LEFT)).toBeVisible();
    answer({ ...READY, statements: [statement(FIRE, 0.9, "button 0 held")] });
    await waitFor(() => expect(screen.queryByText(LEFT)).toBeNull());
    // Three places are kept.
    expect(document.querySelector("ol")).toHaveAttribute("data-places", "3");
  });

  it("shows how far Tril is with learning to see the game, then with watching", async () => {
    const states: Partial<Understanding>[] = [
      { state: "learning", progress: 0.4, statements: [] },
      { state: "watching", progress: 0.5, statements: [] },
      {},
    ];
    open(() => (states.length > 1 ? states.shift() : states[0]) ?? {});
    expect(await screen.findByRole("progressbar")).toHaveAccessibleName(
      /^Tril learns to see Space Invaders: 40%\./,
    );
    expect(
      await screen.findByText(/watches your ranked games/, {}, { timeout: 3000 }),
    ).toBeVisible();
    expect(await screen.findByText(LEFT, {}, { timeout: 3000 })).toBeVisible();
    expect(screen.queryByRole("progressbar")).toBeNull();
  });

  it.each([
    ["waiting", /Rank four games in at least two tiers/],
    ["failed", /could not look at this game/],
    ["ready", /Take one of your answers back/],
  ] as const)("says what to do where nothing is said: %s", async (state, text) => {
    open(() => ({ state, statements: [], is_sense: null }));
    expect(await screen.findByText(text)).toBeVisible();
  });

  it("says why it could not be worked out", async () => {
    serve({ [UNDERSTANDING]: () => new Refusal(422, { detail: "The disk is full." }) });
    show(<UnderstandingPanel behaviourId={1} tiers={[[1], [2]]} perfect={[]} />);
    expect(await screen.findByText(/The disk is full\./)).toBeVisible();
  });

  it("warns of an order that chance explains, and names the games that contradict it", async () => {
    open(() => ({ is_sense: false, contradiction: { better: 7, worse: 9 } }));
    expect(await screen.findByText(/so this may be chance/)).toBeVisible();
    expect(screen.getByText(/Recording 7 is ranked above Recording 9/)).toBeVisible();
  });
});

describe("an answer", () => {
  it("agrees with a statement by the keyboard, keeps the focus and is taken back", async () => {
    const { asked } = open();
    await screen.findByText(LEFT);
    screen.getByRole("button", { name: `This is it: ${LEFT}` }).focus();
    await userEvent.keyboard("{Enter}");
    expect(await screen.findByText("You said: this is it.")).toBeVisible();
    expect(asked.find(({ method }) => method === "PUT")?.body).toEqual({
      subjects: ["thing 12:8-8x9-9 x"],
      sentence: LEFT,
      meant: true,
    });
    expect(panel().getByRole("status")).toHaveTextContent(`Noted as what you mean: ${LEFT}.`);
    const back = screen.getByRole("button", { name: `Take back: ${LEFT}` });
    expect(back).toHaveFocus();
    await waitFor(() => expect(back).toHaveAttribute("aria-disabled", "false"));
    await userEvent.keyboard("{Enter}");
    expect(await screen.findByRole("button", { name: `This is it: ${LEFT}` })).toHaveFocus();
    expect(asked.filter(({ method }) => method === "PUT").at(-1)?.body).toMatchObject({
      meant: null,
    });
  });

  it("rejects a statement, which is then listed apart and can be taken back", async () => {
    let statements = READY.statements;
    open(() => ({ statements }));
    await screen.findByText(LEFT);
    statements = READY.statements.slice(1);
    await userEvent.click(screen.getByRole("button", { name: `Not this: ${LEFT}` }));
    const answers = await screen.findByRole("list", { name: "Your answers" });
    expect(answers).toHaveTextContent(`Not this: ${LEFT}`);
    expect(screen.getByRole("heading", { name: "What Tril understood" })).toHaveFocus();
    const back = within(answers).getByRole("button", { name: `Take back: ${LEFT}` });
    await waitFor(() => expect(back).toHaveAttribute("aria-disabled", "false"));
    await userEvent.click(back);
    await waitFor(() => expect(screen.queryByRole("list", { name: "Your answers" })).toBeNull());
  });

  it("stays listed where no statement is about it any more", async () => {
    const gone = { subjects: ["memory 99 bits"], sentence: "memory 99 with bit 1 on", meant: true };
    open(() => ({ answers: [gone] }));
    expect(await screen.findByRole("list", { name: "Your answers" })).toHaveTextContent(
      "You said that this is it: memory 99 with bit 1 on",
    );
  });
});

describe("the game that would tell", () => {
  const NEXT = { recording_id: 9, other: 1, better_than: 0.9, better_than_by_other: 0.2 };

  /** A fake server that says which game to rank next once it has watched. */
  function choose(states: readonly Partial<Understanding>[], onRank: (id: number) => void) {
    let n = 0;
    const asked = serve({
      [UNDERSTANDING]: ({ body }: Asked) =>
        (body as { with_next: boolean }).with_next
          ? { ...READY, ...states[Math.min(n++, states.length - 1)] }
          : READY,
    });
    show(
      <KnownRecordings value={new Map([[9, recording({ id: 9 })]])}>
        <UnderstandingPanel behaviourId={1} tiers={[[1], [2]]} perfect={[]} onRank={onRank} />
      </KnownRecordings>,
    );
    return asked;
  }

  it("is asked for only when a person wants it, and can be ranked at once", async () => {
    const onRank = vi.fn();
    const asked = choose(
      [{ state: "watching", progress: 0.25, statements: [] }, { next_game: NEXT }],
      onRank,
    );
    const button = await screen.findByRole("button", { name: "Which game should I rank next?" });
    expect(asked.map(({ body }) => body)).toEqual([{ tiers: [[1], [2]], with_next: false }]);
    await userEvent.click(button);
    expect(await screen.findByRole("progressbar")).toHaveAccessibleName(
      "Tril watches your unranked games: 25%.",
    );
    expect(
      await screen.findByText(
        `Ranking Recording 9 would help most. If you mean “${LEFT}”, it is better than 90% of your ranked games; if you mean “${FIRE}”, it is better than 20%.`,
        {},
        { timeout: 3000 },
      ),
    ).toBeVisible();
    await userEvent.click(screen.getByRole("button", { name: "Rank this one next" }));
    expect(onRank).toHaveBeenCalledExactlyOnceWith(9);
  });

  it("is none where all unranked games are alike", async () => {
    choose([{ next_game: null }], vi.fn());
    await userEvent.click(
      await screen.findByRole("button", { name: "Which game should I rank next?" }),
    );
    expect(await screen.findByText(/^No unranked game tells these statements apart/)).toBeVisible();
  });
});

describe("a behaviour", () => {
  it("is read by statements unless the page can draw which items are wanted", () => {
    expect(isReadByStatements(behaviour())).toBe(false);
    expect(isReadByStatements(behaviour({ target: null }))).toBe(true);
    expect(isReadByStatements(behaviour({ game: "pong" }))).toBe(true);
  });
});
