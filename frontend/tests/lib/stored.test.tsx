import { afterEach, describe, expect, it, vi } from "vitest";

import { onOff, readChoice, writeChoice } from "@/lib/stored";

const CHOICE = onOff("tril.test", false);

afterEach(() => vi.restoreAllMocks());

describe("a choice", () => {
  it("is what it falls back to until it is made", () => {
    expect(readChoice(CHOICE)).toBe(false);
    writeChoice(CHOICE, true);
    expect(readChoice(CHOICE)).toBe(true);
    expect(localStorage.getItem("tril.test")).toBe("true");
    localStorage.clear();
    expect(readChoice(CHOICE)).toBe(false);
  });

  it.each(["{", '"yes"', "null"])("falls back where %s is stored", (stored) => {
    localStorage.setItem("tril.test", stored);
    expect(readChoice(CHOICE)).toBe(false);
  });

  it("holds on this page where nothing can be stored", () => {
    vi.spyOn(Storage.prototype, "setItem").mockImplementation(() => {
      throw new DOMException("full", "QuotaExceededError");
    });
    writeChoice(CHOICE, true);
    expect(readChoice(CHOICE)).toBe(true);
    writeChoice(CHOICE, false);
  });
});
