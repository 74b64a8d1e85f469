import { describe, expect, it } from "vitest";

import type { XRange } from "@/features/results/curves/chart-data";
import { movedCursor, shownEnds } from "@/features/results/curves/cursor";
import { moved, selected, type Zoom, zoomedIn, zoomedOut } from "@/features/results/curves/zoom";

function zoom(range: XRange | null): Zoom {
  return { range, full: [0, 1000], change: () => undefined };
}

describe("zooming", () => {
  it("halves and doubles about the middle, within the data", () => {
    expect(zoomedIn(zoom(null))).toEqual([250, 750]);
    expect(zoomedIn(zoom([0, 400]))).toEqual([100, 300]);
    expect(zoomedOut(zoom([0, 200]))).toEqual([0, 400]);
    expect(zoomedOut(zoom([900, 1000]))).toEqual([800, 1000]);
  });

  it("keeps the cursor where it is", () => {
    expect(zoomedIn(zoom([0, 400]), 100)).toEqual([50, 250]);
  });

  it("ends with everything, and with a thousandth of it", () => {
    expect(zoomedOut(zoom([100, 700]))).toBeNull();
    expect(zoomedIn(zoom([10, 11]))).toEqual([10, 11]);
  });

  it("moves as far as there is data", () => {
    expect(moved(zoom([200, 400]), 0.5)).toEqual([300, 500]);
    expect(moved(zoom([850, 950]), 1)).toEqual([900, 1000]);
    expect(moved(zoom(null), 0.5)).toBeNull();
  });

  it("shows what a drag selects, and everything if that is all", () => {
    expect(selected(100, 300, [0, 1000])).toEqual([100, 300]);
    expect(selected(-20, 300, [0, 1000])).toEqual([0, 320]);
    expect(selected(-20, 1020, [0, 1000])).toBeNull();
  });
});

describe("the cursor of a chart", () => {
  it("stays with what is shown", () => {
    expect(shownEnds([0, 1, 2, 3], null)).toEqual([0, 3]);
    expect(shownEnds([0, 1, 2, 3], [0.5, 2.5])).toEqual([1, 2]);
    expect(shownEnds([0, 1], [0, 1])).toEqual([0, 1]);
    expect(shownEnds([], null)).toEqual([0, 0]);
    expect(movedCursor("Home", 2, 1, 2)).toBe(1);
    expect(movedCursor("ArrowLeft", 1, 1, 2)).toBe(1);
  });

  it.each([
    ["ArrowLeft", 4],
    ["ArrowRight", 6],
    ["Home", 0],
    ["End", 30],
    ["PageUp", 25],
    ["PageDown", 0],
    ["a", null],
  ])("moves by %s to %j", (key, index) => expect(movedCursor(key, 5, 0, 30)).toBe(index));
});
