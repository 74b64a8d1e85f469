import { describe, expect, it } from "vitest";

import { keySections } from "@/app/help/page-keys";
import { defaultKeys } from "@/features/play/input/keys";
import { intentOf } from "@/features/play/input/intents";
import { watchIntentOf } from "@/features/play/watch/watch-keys";

import { BLACKJACK, SPACE_INVADERS } from "../../support/games";
import { us } from "../../support/keyboard";

const DEFAULT_KEYS = defaultKeys(SPACE_INVADERS);
const PLAYED = { game: SPACE_INVADERS, keys: DEFAULT_KEYS };

function titles(path: string): string[] {
  return keySections(path, PLAYED).map(({ title }) => title);
}

function keysOf(path: string, title: string): string[] {
  const section = keySections(path, PLAYED).find((one) => one.title === title);
  return section?.rows.flatMap(({ keys }) => keys) ?? [];
}

describe("the keys of a page", () => {
  it.each([
    ["/", ["Everywhere"]],
    ["/behaviours/3/train", ["Everywhere"]],
    ["/behaviours/3/play", ["Playing", "After a game", "Everywhere"]],
    [
      "/behaviours/3/rank",
      ["Ranking", "Placing by comparing", "Watching a recording", "Everywhere"],
    ],
    ["/recordings/3", ["Watching a recording", "Everywhere"]],
    ["/runs/abc/watch", ["Watching imitator or clone play", "Everywhere"]],
    ["/runs/compare", ["On a chart", "Everywhere"]],
    ["/runs/abc", ["On a chart", "Comparing blind", "Watching a recording", "Everywhere"]],
  ])("at %s are those of %j", (path, expected) => expect(titles(path)).toEqual(expected));

  it("of the game are the player's own", () => {
    const keys = { ...DEFAULT_KEYS, fire: ["KeyZ"] };
    const [playing] = keySections("/behaviours/3/play", { game: SPACE_INVADERS, keys });
    expect(playing?.rows.find(({ effect }) => effect.startsWith("fire"))?.keys).toEqual(["Z"]);
  });

  it("name each button of a game, and no rewinding where it can't be", () => {
    const keys = defaultKeys(BLACKJACK);
    const [playing] = keySections("/behaviours/3/play", {
      game: { ...BLACKJACK, saves_states: false },
      keys,
    });
    const effects = playing?.rows.map(({ effect }) => effect) ?? [];
    expect(effects.slice(0, 3)).toEqual(["stick", "hit", "pause"]);
    expect(effects).not.toContain("rewind while held");
  });

  it("do something: letters while playing, after a game and while watching", () => {
    const letters = (keys: readonly string[]) => keys.filter((key) => /^[A-Z]$/.test(key));
    const controls = ["A", "D", "W"];
    for (const key of letters(keysOf("/behaviours/3/play", "Playing"))) {
      if (controls.includes(key)) continue;
      const press = { ...us(`Key${key}`), repeat: false };
      expect([key, intentOf(press, "playing", 0, DEFAULT_KEYS)]).not.toEqual([key, null]);
    }
    for (const key of letters(keysOf("/behaviours/3/play", "After a game"))) {
      const press = { ...us(`Key${key}`), repeat: false };
      expect([key, intentOf(press, "ended", 10_000, DEFAULT_KEYS)]).not.toEqual([key, null]);
    }
    for (const key of letters(keysOf("/runs/abc/watch", "Watching imitator or clone play"))) {
      expect(watchIntentOf({ ...us(`Key${key}`), repeat: false }, 1)).not.toBeNull();
    }
  });
});
