/** The keys that act on a page. */
import { t } from "@lingui/core/macro";
import { matchPath } from "react-router";

import type { TaughtGame } from "@/api/types";
import { DIRECTIONS } from "@/features/play/input/directions";
import { type Control, type KeyMap, keyName } from "@/features/play/input/keys";
import { buttonName } from "@/games/actions";

interface KeyRow {
  /** Each can be pressed. */
  readonly keys: readonly string[];
  readonly effect: string;
}

export interface KeySection {
  readonly title: string;
  readonly rows: readonly KeyRow[];
}

const row = (effect: string, ...keys: readonly string[]): KeyRow => ({ keys, effect });

const everywhere = (): KeySection => ({
  title: t`Everywhere`,
  rows: [
    row(t`these keys`, "?"),
    row(t`next and previous control`, t`Tab`, t`Shift+Tab`),
    row(t`close a dialog`, t`Esc`),
  ],
});

const watch = (): KeySection => ({
  title: t`Watching imitator or clone play`,
  rows: [
    row(t`pause or go on`, t`Space`),
    row(t`one step`, "."),
    row(t`slower, faster`, "−", "+"),
    row(t`restart`, "R"),
    row(t`next start`, "N"),
    row(t`take over the game; with several, by its number`, "T", "1–4"),
  ],
});

const rank = (): KeySection => ({
  title: t`Ranking`,
  rows: [
    row(t`pick a recording up at its handle, and drop it`, t`Space`),
    row(t`choose its place`, "↑", "↓"),
    row(t`put it back`, t`Esc`),
    row(t`undo`, t`Ctrl+Z`),
    row(t`redo`, t`Ctrl+Shift+Z`, t`Ctrl+Y`),
  ],
});

const compare = (): KeySection => ({
  title: t`Placing by comparing`,
  rows: [
    row(t`the left or upper game is better`, "←", "1"),
    row(t`the right or lower game is better`, "→", "2"),
    row(t`it is as good`, "=", "0"),
    row(t`skip it`, "S"),
    row(t`put it below the worst`, "W"),
    row(t`take the last answer back`, "U", "⌫"),
    row(t`play or pause`, t`Space`),
  ],
});

const compareBlind = (): KeySection => ({
  title: t`Comparing blind`,
  rows: [
    row(t`the left or upper game is closer`, "←", "1"),
    row(t`the right or lower game is closer`, "→", "2"),
    row(t`they are equally close`, "=", "0"),
    row(t`take the last answer back`, "U", "⌫"),
    row(t`play or pause`, t`Space`),
  ],
});

const player = (): KeySection => ({
  title: t`Watching a recording`,
  rows: [
    row(t`play or pause`, t`Space`),
    row(t`one frame`, "←", "→"),
    row(t`one step`, t`Shift+←`, t`Shift+→`),
    row(t`start and end`, t`Home`, t`End`),
  ],
});

const charts = (): KeySection => ({
  title: t`On a chart`,
  rows: [
    row(t`read the values`, "←", "→", t`Home`, t`End`),
    row(t`zoom`, "+", "−"),
    row(t`show everything`, "0"),
  ],
});

type NameOf = (code: string) => string;

/** The game of the page, and the keys that the player has assigned to its controls. */
interface Played {
  readonly game: TaughtGame;
  readonly keys: KeyMap;
}

/** The pages with keys of their own, by their routes. */
const PAGES: readonly (readonly [
  pattern: string,
  sections: (played: Played | null, nameOf: NameOf) => readonly KeySection[],
])[] = [
  ["/behaviours/:id/play", playing],
  ["/behaviours/:id/rank", () => [rank(), compare(), player()]],
  ["/behaviours/:id/recordings", () => [player()]],
  ["/recordings/:id", () => [player()]],
  ["/runs/:id/watch", () => [watch()]],
  ["/runs/compare", () => [charts()]],
  ["/runs/:id", () => [charts(), compareBlind(), player()]],
];

/**
 * Returns the keys of the page at a path, and those of every page.
 *
 * @param played The game that is played on the page, if any.
 * @param nameOf Names a key by its code.
 */
export function keySections(
  path: string,
  played: Played | null,
  nameOf: NameOf = keyName,
): readonly KeySection[] {
  const page = PAGES.find(([pattern]) => matchPath(pattern, path));
  return [...(page?.[1](played, nameOf) ?? []), everywhere()];
}

function playing(played: Played | null, nameOf: NameOf): readonly KeySection[] {
  return [...(played ? [whilePlaying(played, nameOf)] : []), afterGame()];
}

function whilePlaying({ game, keys }: Played, nameOf: NameOf): KeySection {
  const of = (...controls: readonly Control[]) =>
    controls.flatMap((control) => (keys[control] ?? []).map((code) => nameOf(code)));
  const directions = DIRECTIONS.filter((one) => game.buttons.includes(one));
  const others = game.buttons.filter((one) => !directions.some((direction) => direction === one));
  return {
    title: t`Playing`,
    rows: [
      ...(directions.length > 0 ? [row(t`move`, ...of(...directions))] : []),
      ...others.map((button) =>
        button === "fire"
          ? row(t`fire, may be held; begins the first game`, ...of(button))
          : row(buttonName(button), ...of(button)),
      ),
      ...(game.saves_states ? [row(t`rewind while held`, ...of("rewind"))] : []),
      row(t`pause`, ...of("pause")),
      row(t`frame by frame`, "."),
      row(t`slower, faster`, "−", "+"),
      row(t`show the targets`, "T"),
      row(t`show the best demonstration`, "G"),
      row(t`show the latency`, "L"),
      row(t`sound`, "M"),
      row(t`fullscreen`, "F"),
    ],
  };
}

const afterGame = (): KeySection => ({
  title: t`After a game`,
  rows: [
    row(t`keep it`, "K", t`Enter`),
    row(t`keep it as perfect`, "P"),
    row(t`discard it`, "X"),
    row(t`play again`, "R", t`Space`),
  ],
});
