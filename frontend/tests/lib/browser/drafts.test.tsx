import { describe, expect, it } from "vitest";

import { dropDraft, forgetDrafts, readDraft, setUnsaved, writeDraft } from "@/lib/browser/drafts";

import { denyStorage } from "../../support/storage";

function asks(): boolean {
  const leaving = new Event("beforeunload", { cancelable: true });
  window.dispatchEvent(leaving);
  return leaving.defaultPrevented;
}

describe("what is not saved", () => {
  it("is kept for a reload, and leaving asks, until it is saved", () => {
    expect(asks()).toBe(false);
    writeDraft("note 1", "steady");
    writeDraft("note 2", { text: "calm" });
    expect(asks()).toBe(true);
    expect(JSON.parse(sessionStorage.getItem("tril.drafts") ?? "")).toEqual({
      "note 1": "steady",
      "note 2": { text: "calm" },
    });
    dropDraft("note 1");
    expect(readDraft("note 1")).toBeUndefined();
    expect(asks()).toBe(true);
    dropDraft("note 2");
    expect(asks()).toBe(false);
  });

  it("is asked about also where storage is denied", () => {
    const allow = denyStorage();
    writeDraft("note 1", "steady");
    expect(readDraft("note 1")).toBe("steady");
    expect(asks()).toBe(true);
    forgetDrafts();
    expect(readDraft("note 1")).toBeUndefined();
    expect(asks()).toBe(false);
    allow();
  });

  it("may be on its way", () => {
    setUnsaved("what is being sent", true);
    expect(asks()).toBe(true);
    setUnsaved("what is being sent", false);
    expect(asks()).toBe(false);
  });
});
