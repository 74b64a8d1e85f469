/** The keys that act on a page. */
import { matchPath } from "react-router";

import { type Control, type KeyMap, keyName } from "@/features/play/input/keys";

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

const EVERYWHERE: KeySection = {
  title: "Everywhere",
  rows: [
    row("these keys", "?"),
    row("next and previous control", "Tab", "Shift+Tab"),
    row("close a dialog", "Esc"),
  ],
};

const WATCH: KeySection = {
  title: "Watching a policy play",
  rows: [
    row("pause or go on", "Space"),
    row("one step", "."),
    row("slower, faster", "−", "+"),
    row("restart", "R"),
    row("next start", "N"),
    row("take over the game; with several, by its number", "T", "1–4"),
  ],
};

const RANK: KeySection = {
  title: "Ranking",
  rows: [
    row("pick a recording up at its handle, and drop it", "Space"),
    row("choose its place", "↑", "↓"),
    row("put it back", "Esc"),
    row("undo", "Ctrl+Z"),
    row("redo", "Ctrl+Shift+Z", "Ctrl+Y"),
  ],
};

const PLAYER: KeySection = {
  title: "Watching a recording",
  rows: [
    row("play or pause", "Space"),
    row("one frame", "←", "→"),
    row("one step", "Shift+←", "Shift+→"),
    row("start and end", "Home", "End"),
  ],
};

const CHARTS: KeySection = {
  title: "On a chart",
  rows: [
    row("read the values", "←", "→", "Home", "End"),
    row("zoom", "+", "−"),
    row("show everything", "0"),
  ],
};

/** The pages with keys of their own, by their routes. */
const PAGES: readonly (readonly [
  pattern: string,
  sections: (keys: KeyMap) => readonly KeySection[],
])[] = [
  ["/behaviours/:id/play", playing],
  ["/behaviours/:id/rank", () => [RANK, PLAYER]],
  ["/behaviours/:id/recordings", () => [PLAYER]],
  ["/recordings/:id", () => [PLAYER]],
  ["/runs/:id/watch", () => [WATCH]],
  ["/runs/compare", () => [CHARTS]],
  ["/runs/:id", () => [CHARTS, PLAYER]],
];

/**
 * Returns the keys of the page at a path, and those of every page.
 *
 * @param keys The keys that the player has assigned to the game's controls.
 */
export function keySections(path: string, keys: KeyMap): readonly KeySection[] {
  const page = PAGES.find(([pattern]) => matchPath(pattern, path));
  return [...(page?.[1](keys) ?? []), EVERYWHERE];
}

function playing(keys: KeyMap): readonly KeySection[] {
  const of = (...controls: readonly Control[]) =>
    controls.flatMap((control) => keys[control].map(keyName));
  return [
    {
      title: "Playing",
      rows: [
        row("move", ...of("left", "right")),
        row("fire, may be held; begins the first game", ...of("fire")),
        row("rewind while held", ...of("rewind")),
        row("pause", ...of("pause")),
        row("frame by frame", "."),
        row("slower, faster", "−", "+"),
        row("show the targets", "T"),
        row("show the best demonstration's cannon", "G"),
        row("show the latency", "L"),
        row("sound", "M"),
        row("fullscreen", "F"),
      ],
    },
    {
      title: "After a game",
      rows: [
        row("keep it", "K", "Enter"),
        row("keep it as perfect", "P"),
        row("discard it", "X"),
        row("play again", "R", "Space"),
      ],
    },
  ];
}
