import { describe, expect, it } from "vitest";

import { continuing, withSearch } from "@/lib/continuing";

describe("the run to continue", () => {
  const lead = (search: string) => withSearch("/train", continuing(new URLSearchParams(search)));

  it("is all that is led on with", () => {
    expect(lead("compare&continue=a1&steps=20&tour")).toBe("/train?continue=a1&steps=20");
  });

  it("needs no number of steps", () => {
    expect(lead("continue=a1")).toBe("/train?continue=a1");
  });

  it("takes the steps with it where it is dropped", () => {
    expect(lead("steps=20")).toBe("/train");
  });
});
