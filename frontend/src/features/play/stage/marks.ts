/** Draws over the game what helps to play it well; nothing of it is streamed or recorded. */
import type { Ghost } from "@/api/types";
import {
  type AlienGeometry,
  alienBox,
  cellsLeft,
  hitsUntil,
} from "@/features/play/stream/formation";
import type { SeenFrame } from "@/features/play/stream/game-stream";
import type { HitAt } from "@/features/play/stream/text-messages";
import type { Cell } from "@/lib/game/aliens";
import { SCREEN_HEIGHT, SCREEN_WIDTH } from "@/lib/game/codec";

/** What is to be drawn; null for nothing. */
export interface Marks {
  readonly target: readonly Cell[] | null;
  readonly ghost: Ghost | null;
}

/** CSS colours. */
export interface MarkColours {
  readonly target: string;
  readonly ghost: string;
}

/** The ghost must not hide the cannon that stands where it does. */
const GHOST_ALPHA = 0.5;
/** The barrel takes the middle three of a cannon's seven parts, above its base of four rows. */
const BARREL_FROM = 2 / 7;
const BARREL_WIDTH = 3 / 7;
const BASE_HEIGHT = 4;

/** Marks on one canvas of the game's own pixels; drawn anew only when something moves. */
export class MarksPainter {
  private readonly context: CanvasRenderingContext2D;
  private readonly marks: Marks;
  private readonly colours: MarkColours;
  private left = NaN;
  private top = NaN;
  private cannon: number | null = null;
  private nHits = 0;

  constructor(canvas: HTMLCanvasElement, marks: Marks, colours: MarkColours) {
    const context = canvas.getContext("2d");
    if (!context) throw new Error("This browser can't draw on a canvas.");
    canvas.width = SCREEN_WIDTH;
    canvas.height = SCREEN_HEIGHT;
    this.context = context;
    this.marks = marks;
    this.colours = colours;
  }

  /** Shows the marks of a frame. */
  show({ frame, formation }: SeenFrame, hits: readonly HitAt[], aliens: AlienGeometry): void {
    const { left, top } = formation;
    const nHits = hitsUntil(hits, frame);
    const cannon = this.marks.ghost?.lefts[frame] ?? null;
    const stays =
      left === this.left && top === this.top && nHits === this.nHits && cannon === this.cannon;
    if (stays) return;
    this.left = left;
    this.top = top;
    this.nHits = nHits;
    this.cannon = cannon;
    this.context.clearRect(0, 0, SCREEN_WIDTH, SCREEN_HEIGHT);
    const { target } = this.marks;
    if (target) this.outline(cellsLeft(target, hits, nHits), formation, aliens);
    if (cannon !== null) this.haunt(cannon);
  }

  /** Frames aliens, a pixel away from them. */
  private outline(
    cells: readonly Cell[],
    formation: SeenFrame["formation"],
    aliens: AlienGeometry,
  ): void {
    const { context } = this;
    context.strokeStyle = this.colours.target;
    context.lineWidth = 1;
    for (const cell of cells) {
      const { left, top, width, height } = alienBox(cell, formation, aliens);
      context.strokeRect(left - 1.5, top - 1.5, width + 3, height + 3);
    }
  }

  /** Draws the ghost's cannon. */
  private haunt(left: number): void {
    const { context } = this;
    const { ghost } = this.marks;
    if (!ghost) return;
    const { top, width, height } = ghost;
    context.globalAlpha = GHOST_ALPHA;
    context.fillStyle = this.colours.ghost;
    context.fillRect(left + width * BARREL_FROM, top, width * BARREL_WIDTH, height - BASE_HEIGHT);
    context.fillRect(left, top + height - BASE_HEIGHT, width, BASE_HEIGHT);
    context.globalAlpha = 1;
  }
}
