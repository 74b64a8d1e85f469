import { screen } from "@testing-library/react";
import { expect, it } from "vitest";

import { EndLabels } from "@/features/results/labels/EndLabels";

import { show } from "../../../support/page";

const LINE = { colour: "red", dashed: false, value: "2.6", bounds: null, last: 2.6 };

function open(names: readonly string[], isNamed: boolean) {
  show(
    <EndLabels
      labels={names.map((name) => ({ ...LINE, name }))}
      isNamed={isNamed}
      plot={{ current: null }}
      onWidth={() => undefined}
    />,
  );
  return screen.getAllByRole("listitem").map(({ textContent }) => textContent);
}

it("a chart's only line has its value alone", () => {
  expect(open(["Run a1"], false)).toEqual(["2.6"]);
});

it("it has its name, too, where the title does not say whose it is", () => {
  expect(open(["Run a1"], true)).toEqual(["Run a12.6"]);
});

it("lines side by side have their names", () => {
  expect(open(["training", "held-out"], false)).toEqual(["training2.6", "held-out2.6"]);
});
