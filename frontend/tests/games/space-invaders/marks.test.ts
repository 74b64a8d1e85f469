import { beforeEach, describe, expect, it, vi } from "vitest";

import type { Ghost } from "@/api/types";
import { AlienMarks } from "@/games/space-invaders/marks";
import type { HitAt } from "@/features/play/stream/text-messages";

const ALIENS = { width: 8, height: 10, column_px: 16, row_px: 18 };
const GHOST: Ghost = {
  recording_id: 5,
  number: 2,
  source: "scripted",
  lefts: [34, 34, 35],
  top: 185,
  width: 7,
  height: 10,
};
const HIT: HitAt = { row: 0, column: 0, frame: 2, on_target: true };
const TARGET = [
  [0, 0],
  [1, 0],
] as const;
const COLOURS = { target: "lime", ghost: "pink" };

const context = {
  clearRect: vi.fn(),
  strokeRect: vi.fn(),
  fillRect: vi.fn(),
  strokeStyle: "",
  fillStyle: "",
  lineWidth: 0,
  globalAlpha: 1,
};

function painter(marks: ConstructorParameters<typeof AlienMarks>[1]) {
  const canvas = { getContext: () => context } as unknown as HTMLCanvasElement;
  return new AlienMarks(canvas, marks, COLOURS, ALIENS);
}

function seen(frame: number, left = 23, top = 31) {
  return { frame, marks: Uint8Array.of(left + 96, top), hasCounted: false };
}

beforeEach(() => {
  vi.clearAllMocks();
});

describe("marks over the game", () => {
  it("outline the targets that are left, where they stand", () => {
    const marks = painter({ target: TARGET, ghost: null });
    marks.show(seen(1), [HIT]);
    expect(context.strokeRect.mock.calls).toEqual([
      [21.5, 119.5, 11, 13],
      [21.5, 101.5, 11, 13],
    ]);
    expect(context.strokeStyle).toBe("lime");
    context.strokeRect.mockClear();
    marks.show(seen(2, 25, 33), [HIT]);
    expect(context.strokeRect.mock.calls).toEqual([[23.5, 103.5, 11, 13]]);
    expect(context.fillRect).not.toHaveBeenCalled();
  });

  it("are drawn anew only when something moves", () => {
    const marks = painter({ target: TARGET, ghost: null });
    for (let frame = 0; frame < 30; frame += 1) marks.show(seen(frame), []);
    expect(context.clearRect).toHaveBeenCalledTimes(1);
    marks.show(seen(30, 24), []);
    marks.show(seen(31, 24), [{ ...HIT, frame: 31 }]);
    expect(context.clearRect).toHaveBeenCalledTimes(3);
  });

  it("show the ghost at the game's frame, for as long as its recording goes", () => {
    const marks = painter({ target: null, ghost: GHOST });
    marks.show(seen(2), []);
    expect(context.fillRect.mock.calls.map(([left]) => left as number)).toEqual([37, 35]);
    expect(context.fillStyle).toBe("pink");
    context.fillRect.mockClear();
    marks.show(seen(3), []);
    expect(context.clearRect).toHaveBeenCalledTimes(2);
    expect(context.fillRect).not.toHaveBeenCalled();
    expect(context.strokeRect).not.toHaveBeenCalled();
    expect(context.globalAlpha).toBe(1);
  });
});
