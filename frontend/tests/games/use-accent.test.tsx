import { renderHook } from "@testing-library/react";
import { afterEach, describe, expect, it, vi } from "vitest";

import { useAccent } from "@/games/use-accent";

describe("the accent of a game", () => {
  afterEach(() => vi.unstubAllGlobals());

  it("is the page's own where a browser has no canvas off the screen", async () => {
    const decode = vi.fn(() => Promise.resolve());
    vi.stubGlobal(
      "Image",
      class {
        src = "";
        naturalWidth = 4;
        naturalHeight = 4;
        decode = decode;
      },
    );
    vi.stubGlobal("OffscreenCanvas", undefined);
    const problems: unknown[] = [];
    const note = (problem: unknown) => problems.push(problem);
    process.on("unhandledRejection", note);
    renderHook(() => useAccent("/picture.png"));
    await new Promise((resolve) => setTimeout(resolve, 20));
    process.off("unhandledRejection", note);
    expect(decode).toHaveBeenCalled();
    expect(problems).toEqual([]);
  });
});
