import { describe, expect, it } from "vitest";

import { newTabId } from "@/features/play/stream/tab";

describe("a tab's id", () => {
  it("is a random UUID", () => {
    const ids = Array.from({ length: 20 }, newTabId);
    expect(new Set(ids).size).toBe(20);
    for (const id of ids) {
      expect(id).toMatch(/^[0-9a-f]{8}-[0-9a-f]{4}-4[0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}$/);
    }
  });
});
