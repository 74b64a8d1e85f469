import { screen } from "@testing-library/react";
import { describe, expect, it, vi } from "vitest";

import type { StatementAnswer } from "@/api/types";
import { StatementList } from "@/components/statements/StatementList";

import { show } from "../../support/page";

const STATEMENT = {
  sentence: "what you steer further to the left",
  detail: "memory 22 by a table",
  probability: 0.76,
  subjects: ["thing 40:8-8x6-6 x"],
  kinds: [0],
  shown: null,
  contrast: null,
  pictures: [] as string[],
};

function open(said: readonly StatementAnswer[], pictures: string[] = []) {
  show(
    <StatementList
      behaviourId={1}
      statements={[{ ...STATEMENT, pictures }]}
      answers={said}
      answering={{ say: vi.fn(), isAnswering: false, spoken: "" }}
    />,
  );
}

function saying(meant: boolean): StatementAnswer {
  const { subjects, sentence } = STATEMENT;
  return { subjects, sentence, meant };
}

describe("statements", () => {
  it("begin with the picture of what they are about", () => {
    open([], ["/thing.png"]);
    const [first] = screen.getByRole("listitem").children;
    expect(first?.querySelector("img")).toHaveAttribute("src", "/thing.png");
  });

  it("leave no hole where there is no picture yet", () => {
    open([]);
    expect(screen.getByRole("listitem").firstElementChild).toHaveTextContent(STATEMENT.sentence);
  });

  it("begin with what a person recognises and leave the byte to a second line", () => {
    open([]);
    expect(screen.getByText(STATEMENT.sentence, { exact: false })).toBeVisible();
    expect(screen.getByText("memory 22 by a table")).toBeVisible();
    expect(screen.getByText("76%")).toBeVisible();
  });

  it("show no probability beside what a person is sure of", () => {
    open([saying(true)]);
    expect(screen.getByText("You said: this is it.")).toBeVisible();
    expect(screen.getByText("Counts for sure")).toBeVisible();
    expect(screen.queryByText(/%/)).toBeNull();
  });

  it("show none beside what a person ruled out", () => {
    open([saying(false)]);
    expect(screen.getByText("Left out")).toBeVisible();
    expect(screen.queryByText(/%/)).toBeNull();
  });
});
