/** What the page can know of a game besides what the server tells of every game. */
import type { ComponentType, ReactNode } from "react";

import type { Behaviour, Ghost, WantedItems } from "@/api/types";
import type { Cell, ItemPath } from "@/lib/game/items";

/** The words for a game's ends and items, in the page's language. */
export interface GameWords {
  /** How games end, by the names of the ends, within a sentence: "the time was over". */
  ends: () => Readonly<Record<string, string>>;
  /** When games end before their time, by the names of the rules: "when a life is lost". */
  rules: () => Readonly<Record<string, string>>;
  /** Things and counts of the game, by what the server calls them. */
  titles: () => Readonly<Record<string, string>>;
  /** "No brick broken". */
  noneTaken: () => string;
  /** "Bricks broken". */
  takenTitle: () => string;
  /** "Brick in row 1, column 2". */
  at: (cell: string) => string;
  /** "3 bricks chosen". */
  chosen: (count: number) => string;
  /** "Target bricks". */
  targets: () => string;
  /** "Target certain bricks". */
  choosesTargets: () => string;
  /** "Pick at least one brick, or turn the target off." */
  noTarget: () => string;
}

export interface WantedProps {
  title: string;
  inferred: WantedItems;
  behaviour: Behaviour;
  /** CSS pixels per pixel of the drawing. */
  scale: 2 | 3;
  /** More of how to read it. */
  children?: ReactNode;
}

/** What may be drawn over the screens: the name of a painter, and its constants. */
export interface Overlay {
  readonly painter: string;
  readonly geometry: Readonly<Record<string, number>>;
}

/** Visual aids drawn over the game, never recorded; null for none. */
export interface Marks {
  readonly target: readonly Cell[] | null;
  readonly ghost: Ghost | null;
}

/** As CSS colours. */
export interface MarkColours {
  readonly target: string;
  readonly ghost: string;
}

/** What a frame carries besides its screen. */
export interface FrameInfo {
  readonly frame: number;
  /** What the overlay needs of this frame, two bytes. */
  readonly marks: Uint8Array;
  /** Whether one of the game's counters has risen since the previous frame. */
  readonly hasCounted: boolean;
}

export interface TakenAt {
  readonly row: number;
  readonly column: number;
  readonly frame: number;
}

/** Draws marks on a canvas of the game's resolution. */
export interface MarksPainter {
  show: (info: FrameInfo, hits: readonly TakenAt[]) => void;
}

export interface GameView {
  readonly words: GameWords;
  readonly itemPath: ItemPath;
  /** Shows what a reward model infers to be wanted. */
  readonly Wanted: ComponentType<WantedProps>;
  /** Makes a painter of marks; null if the overlay is not one that it knows. */
  readonly marksPainter: (
    canvas: HTMLCanvasElement,
    marks: Marks,
    colours: MarkColours,
    overlay: Overlay,
  ) => MarksPainter | null;
}
