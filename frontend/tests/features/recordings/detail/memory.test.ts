import { describe, expect, it } from "vitest";

import { hex, memoryAt, RAM_SIZE } from "@/features/recordings/detail/memory";

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
