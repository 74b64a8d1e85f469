import { afterEach, describe, expect, it, vi } from "vitest";

import { onOff, readSetting, writeSetting } from "@/features/play/settings/stored";

const SETTING = onOff("tril.test", false);

afterEach(() => vi.restoreAllMocks());

describe("a setting", () => {
  it("has its fallback until it is written", () => {
    expect(readSetting(SETTING)).toBe(false);
    writeSetting(SETTING, true);
    expect(readSetting(SETTING)).toBe(true);
    expect(localStorage.getItem("tril.test")).toBe("true");
    localStorage.clear();
    expect(readSetting(SETTING)).toBe(false);
  });

  it.each(["{", '"yes"', "null"])("falls back if %s is stored", (stored) => {
    localStorage.setItem("tril.test", stored);
    expect(readSetting(SETTING)).toBe(false);
  });

  it("lasts on this page if nothing can be stored", () => {
    vi.spyOn(Storage.prototype, "setItem").mockImplementation(() => {
      throw new DOMException("full", "QuotaExceededError");
    });
    writeSetting(SETTING, true);
    expect(readSetting(SETTING)).toBe(true);
    writeSetting(SETTING, false);
  });
});
