import { afterEach, describe, expect, it, vi } from "vitest";

import { onOff, readSetting, writeSetting } from "@/features/play/settings/stored";

const CHOICE = onOff("tril.test", false);

afterEach(() => vi.restoreAllMocks());

describe("a choice", () => {
  it("is what it falls back to until it is made", () => {
    expect(readSetting(CHOICE)).toBe(false);
    writeSetting(CHOICE, true);
    expect(readSetting(CHOICE)).toBe(true);
    expect(localStorage.getItem("tril.test")).toBe("true");
    localStorage.clear();
    expect(readSetting(CHOICE)).toBe(false);
  });

  it.each(["{", '"yes"', "null"])("falls back where %s is stored", (stored) => {
    localStorage.setItem("tril.test", stored);
    expect(readSetting(CHOICE)).toBe(false);
  });

  it("holds on this page where nothing can be stored", () => {
    vi.spyOn(Storage.prototype, "setItem").mockImplementation(() => {
      throw new DOMException("full", "QuotaExceededError");
    });
    writeSetting(CHOICE, true);
    expect(readSetting(CHOICE)).toBe(true);
    writeSetting(CHOICE, false);
  });
});
