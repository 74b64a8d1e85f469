import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { render, screen, waitFor } from "@testing-library/react";
import userEvent from "@testing-library/user-event";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";

import { preferredLanguage, readLanguage, setLanguage, startLanguage } from "@/app/language";
import { PlayerMenu } from "@/app/layout/PlayerMenu";
import { Localised } from "@/app/Localised";
import { bytes, fixed, moment, ordinal, percent, whole } from "@/lib/format";
import { i18n } from "@/lib/i18n";
import { describeCourse, describeResult } from "@/games/outcomes";

import { behaviour, recording } from "../support/data";
import { SPACE_INVADERS } from "../support/games";
import { show } from "../support/page";
import { serve } from "../support/server";

function prefer(...languages: string[]) {
  vi.spyOn(navigator, "languages", "get").mockReturnValue(languages);
}

beforeEach(() => prefer("en-US", "en"));

afterEach(async () => {
  await setLanguage("en");
  localStorage.clear();
});

describe("the language", () => {
  it.each([
    [["de-AT", "en"], "de"],
    [["fr", "de", "en"], "de"],
    [["en-GB", "de"], "en"],
    [["fr", "ja"], "en"],
    [[], "en"],
  ])("of a browser that prefers %j is %s", (languages, expected) => {
    prefer(...languages);
    expect(preferredLanguage()).toBe(expected);
  });

  it("is the one that was chosen here, whatever the browser prefers", async () => {
    prefer("en-US");
    await setLanguage("de");
    expect(preferredLanguage()).toBe("de");
  });

  it("is the browser's if what is stored is none of the page's", () => {
    prefer("de");
    localStorage.setItem("tril.language", "tlh");
    expect(preferredLanguage()).toBe("de");
  });

  it("is that of the document, too, for screen readers and hyphenation", async () => {
    prefer("de-DE");
    await startLanguage();
    expect(document.documentElement.lang).toBe("de");
    expect(readLanguage()).toBe("de");
  });

  it("is there for scripts where the machine's locale is none", async () => {
    vi.spyOn(navigator, "language", "get").mockReturnValue("C");
    await startLanguage();
    expect(navigator.language).toBe("en");
    Reflect.deleteProperty(navigator, "language");
    vi.restoreAllMocks();
    expect(navigator.language).toBe("en-US");
  });

  it("is chosen beside the player's name and changes the page at once", async () => {
    serve({ "GET /api/player": () => ({ id: 1, name: "Ada", role: "owner" }) });
    show(
      <Localised>
        <PlayerMenu />
      </Localised>,
    );
    await userEvent.click(await screen.findByRole("button", { name: /Player: Ada/ }));
    await userEvent.selectOptions(screen.getByLabelText("Language"), "Deutsch");
    expect(await screen.findByRole("button", { name: "Name: Ada. Ändern" })).toBeVisible();
    expect(localStorage.getItem("tril.language")).toBe("de");
    await waitFor(() => expect(document.documentElement.lang).toBe("de"));
  });
});

describe("a text", () => {
  it("is in English where the catalogue has none", async () => {
    await setLanguage("de");
    expect(i18n._({ id: "unheard of", message: "Nobody translated this." })).toBe(
      "Nobody translated this.",
    );
    const n = 1;
    // Not in src/, thus in no catalogue.
    expect(t`Untranslated ${n}`).toBe("Untranslated 1");
    render(
      <Trans>
        Untranslated, <strong>in part</strong>
      </Trans>,
    );
    expect(screen.getByText("in part").tagName).toBe("STRONG");
  });

  it.each([
    ["en", 1, "1 target"],
    ["en", 3000, "3,000 targets"],
  ] as const)("in %s has the plural of %d", async (language, n, text) => {
    await setLanguage(language);
    expect(plural(n, { one: "# target", other: "# targets" })).toBe(text);
  });

  it("has the plural of its own language", async () => {
    const column = behaviour({ target: Array.from({ length: 6 }, (_, row) => [row, 0]) });
    const score = (n: number) =>
      describeResult({ ...recording(), targets: 3, strays: n }, column, SPACE_INVADERS);
    expect([score(0), score(1), score(2)]).toEqual([
      "3 of 6 targets, no strays",
      "3 of 6 targets, 1 stray",
      "3 of 6 targets, 2 strays",
    ]);
    await setLanguage("de");
    expect([score(0), score(1)]).toEqual([
      "3 von 6 Zielen, keine Fehltreffer",
      "3 von 6 Zielen, 1 Fehltreffer",
    ]);
    const course = (n: number) =>
      describeCourse({ ...recording(), end: null, n_steps: n }, SPACE_INVADERS);
    expect([course(1), course(2)]).toEqual([
      "1 Schritt, 20,0\u00a0s, vorzeitig beendet",
      "2 Schritte, 20,0\u00a0s, vorzeitig beendet",
    ]);
  });
});

describe("numbers and dates", () => {
  it("are written as in the language", async () => {
    await setLanguage("de");
    expect(whole(12_345)).toBe("12.345");
    expect(fixed(-9.25, 2)).toBe("−9,25");
    expect(percent(0.984)).toBe("98,4\u00a0%");
    expect(bytes(1_500_000)).toBe("1,5\u00a0MB");
    expect(ordinal(2)).toBe("2.");
    expect(moment("2026-03-04T12:00:00Z")).toContain("März 2026");
    await setLanguage("en");
    expect(fixed(-9.25, 2)).toBe("−9.25");
    expect(percent(0.984)).toBe("98.4%");
  });
});
