import { describe, expect, it } from "vitest";

import { newUuid } from "@/lib/browser/uuid";

describe("a UUID", () => {
  it("is random, and of version 4", () => {
    const ids = Array.from({ length: 20 }, newUuid);
    expect(new Set(ids).size).toBe(20);
    for (const id of ids) {
      expect(id).toMatch(/^[0-9a-f]{8}-[0-9a-f]{4}-4[0-9a-f]{3}-[89ab][0-9a-f]{3}-[0-9a-f]{12}$/);
    }
  });
});
