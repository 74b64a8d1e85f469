/** Visual aids drawn over the game: outlines of the targets and a ghost. */
import type { FrameInfo, MarkColours, Marks, MarksPainter, TakenAt } from "@/games/view";
import type { Cell } from "@/lib/game/items";

import {
  type AlienGeometry,
  alienBox,
  cellsLeft,
  type Formation,
  formationOf,
  hitsUntil,
} from "./formation";

/** Translucent, so that the ghost does not hide the cannon. */
const GHOST_ALPHA = 0.5;
/** The barrel takes the middle three of a cannon's seven parts, above its base of four rows. */
const BARREL_FROM = 2 / 7;
const BARREL_WIDTH = 3 / 7;
const BASE_HEIGHT = 4;

/** Draws marks on a canvas of the game's resolution, redrawn only when something moves. */
export class AlienMarks implements MarksPainter {
  private readonly canvas: HTMLCanvasElement;
  private readonly context: CanvasRenderingContext2D;
  private readonly marks: Marks;
  private readonly colours: MarkColours;
  private readonly aliens: AlienGeometry;
  private left = NaN;
  private top = NaN;
  private cannon: number | null = null;
  private nHits = 0;

  constructor(
    canvas: HTMLCanvasElement,
    marks: Marks,
    colours: MarkColours,
    aliens: AlienGeometry,
  ) {
    const context = canvas.getContext("2d");
    if (!context) throw new Error("This browser can't draw on a canvas.");
    this.canvas = canvas;
    this.context = context;
    this.marks = marks;
    this.colours = colours;
    this.aliens = aliens;
  }

  /** Draws the marks of a frame. */
  show({ frame, marks }: FrameInfo, hits: readonly TakenAt[]): void {
    const formation = formationOf(marks);
    const { left, top } = formation;
    const nHits = hitsUntil(hits, frame);
    const cannon = this.marks.ghost?.lefts[frame] ?? null;
    const unchanged =
      left === this.left && top === this.top && nHits === this.nHits && cannon === this.cannon;
    if (unchanged) return;
    this.left = left;
    this.top = top;
    this.nHits = nHits;
    this.cannon = cannon;
    this.context.clearRect(0, 0, this.canvas.width, this.canvas.height);
    const { target } = this.marks;
    if (target) this.drawOutlines(cellsLeft(target, hits, nHits), formation);
    if (cannon !== null) this.drawGhost(cannon);
  }

  /** Outlines aliens at a distance of one pixel. */
  private drawOutlines(cells: readonly Cell[], formation: Formation): void {
    const { context, aliens } = this;
    context.strokeStyle = this.colours.target;
    context.lineWidth = 1;
    for (const cell of cells) {
      const { left, top, width, height } = alienBox(cell, formation, aliens);
      context.strokeRect(left - 1.5, top - 1.5, width + 3, height + 3);
    }
  }

  private drawGhost(left: number): void {
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
