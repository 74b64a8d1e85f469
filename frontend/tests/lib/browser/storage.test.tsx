import { afterEach, beforeEach, describe, expect, it } from "vitest";

import { areNotificationsOn, turnNotificationsOff } from "@/lib/browser/notifications";
import { ofBrowser, ofTab } from "@/lib/browser/storage";

import { denyStorage } from "../../support/storage";

describe("storage", () => {
  it("keeps what is written until it is removed", () => {
    ofTab.write("tril.storage", "1");
    expect(ofTab.read("tril.storage")).toBe("1");
    expect(sessionStorage.getItem("tril.storage")).toBe("1");
    ofTab.remove("tril.storage");
    expect(ofTab.read("tril.storage")).toBeNull();
  });
});

describe("storage that is denied", () => {
  let allow: () => void;
  beforeEach(() => {
    allow = denyStorage();
  });
  afterEach(() => allow());

  it.each([ofBrowser, ofTab])("keeps values until the page is closed", (storage) => {
    expect(storage.read("tril.storage")).toBeNull();
    storage.write("tril.storage", "1");
    expect(storage.read("tril.storage")).toBe("1");
    storage.remove("tril.storage");
    expect(storage.read("tril.storage")).toBeNull();
  });

  it("leaves notifications off", () => {
    expect(areNotificationsOn()).toBe(false);
    turnNotificationsOff();
  });
});
