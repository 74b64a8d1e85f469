import { describe, expect, it } from "vitest";

import { actionInWords, lanesOf } from "@/lib/actions";
import { hex, memoryAt, RAM_SIZE } from "@/lib/memory";

describe("actions", () => {
  const actions = [0, 4, 4, 2, 0, 5];

  it("are named by the frame that they led to", () => {
    expect(actionInWords(actions, 0)).toBe("the start");
    expect(actionInWords(actions, 1)).toBe("nothing");
    expect(actionInWords(actions, 2)).toBe("right and fire");
    expect(actionInWords(actions, 4)).toBe("right");
    expect(actionInWords(actions, 6)).toBe("left and fire");
    expect(actionInWords(actions, 7)).toBe("none");
  });

  it("say from which frame to which each key was held", () => {
    expect(lanesOf(actions)).toEqual([
      { name: "left", spans: [{ from: 6, to: 6 }] },
      { name: "right", spans: [{ from: 2, to: 4 }] },
      {
        name: "fire",
        spans: [
          { from: 2, to: 3 },
          { from: 6, to: 6 },
        ],
      },
    ]);
  });
});

describe("memory", () => {
  const memory = new Uint8Array(3 * RAM_SIZE);
  memory[RAM_SIZE + 28] = 35;
  memory[2 * RAM_SIZE + 28] = 36;

  it("tells what changed in a frame", () => {
    expect(memoryAt(memory, 0).some(({ changed }) => changed)).toBe(false);
    expect(memoryAt(memory, 2)[28]).toEqual({ address: 28, value: 36, changed: true });
    expect(memoryAt(memory, 2)[29]?.changed).toBe(false);
    expect(memoryAt(memory, 9)).toEqual(memoryAt(memory, 2));
  });

  it("is written in two digits", () => {
    expect([0, 10, 255].map(hex)).toEqual(["00", "0a", "ff"]);
  });
});
