import { afterEach, beforeEach, describe, expect, it } from "vitest";

import { areNotificationsOn, turnNotificationsOff } from "@/lib/browser/notifications";
import { ofBrowser, ofTab } from "@/lib/browser/storage";

import { denyStorage } from "../../support/storage";

describe("storage", () => {
  it("keeps what is written until it is removed", () => {
    ofTab.write("tril.test", "1");
    expect(ofTab.read("tril.test")).toBe("1");
    expect(sessionStorage.getItem("tril.test")).toBe("1");
    ofTab.remove("tril.test");
    expect(ofTab.read("tril.test")).toBeNull();
  });
});

describe("storage that is denied", () => {
  let allow: () => void;
  beforeEach(() => {
    allow = denyStorage();
  });
  afterEach(() => allow());

  it.each([ofBrowser, ofTab])("keeps values until the page is closed", (storage) => {
    expect(storage.read("tril.test")).toBeNull();
    storage.write("tril.test", "1");
    expect(storage.read("tril.test")).toBe("1");
    storage.remove("tril.test");
    expect(storage.read("tril.test")).toBeNull();
  });

  it("leaves notifications off", () => {
    expect(areNotificationsOn()).toBe(false);
    turnNotificationsOff();
  });
});
