import { expect, it } from "vitest";

import { curvesCsv } from "@/features/results/curves/csv";

it("curves are saved one point a row, by run, stage and name", () => {
  const series = {
    reward: { loss: [[1, 0.7] as const] },
    imitator: { hits: [[128, 2] as const, [256, 2.5] as const] },
  };
  expect(curvesCsv([{ run: 'Wide, "big"', series }]).split("\r\n")).toEqual([
    "run,stage,curve,step,value",
    '"Wide, ""big""",reward,loss,1,0.7',
    '"Wide, ""big""",imitator,hits,128,2',
    '"Wide, ""big""",imitator,hits,256,2.5',
    "",
  ]);
});

it("a name that a spreadsheet would compute is text", () => {
  const series = { reward: { loss: [[1, 0.7] as const] } };
  expect(curvesCsv([{ run: "=1+1", series }])).toContain("'=1+1,reward,loss,1,0.7");
});
