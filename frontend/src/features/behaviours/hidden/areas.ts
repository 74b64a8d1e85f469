/** Rectangles of the screen that learning does not see, in its pixels. */

/** Right and bottom lie outside. */
export type Area = readonly [left: number, top: number, right: number, bottom: number];

export interface ScreenPixels {
  readonly width: number;
  readonly height: number;
}

interface Point {
  readonly x: number;
  readonly y: number;
}

/** Most areas that the server takes. */
export const MOST_AREAS = 16;
/** Side of a new area that is added by its button. */
const NEW_PX = 20;

/** Returns the area between two corners, within the screen; at least one pixel. */
export function between(one: Point, other: Point, screen: ScreenPixels): Area {
  const [left, right] = span(one.x, other.x, screen.width);
  const [top, bottom] = span(one.y, other.y, screen.height);
  return [left, top, right, bottom];
}

function span(one: number, other: number, most: number): [number, number] {
  const low = clamp(Math.floor(Math.min(one, other)), 0, most - 1);
  return [low, clamp(Math.ceil(Math.max(one, other)), low + 1, most)];
}

/** Moves an area, which keeps its size and stays within the screen. */
export function moved([left, top, right, bottom]: Area, by: Point, screen: ScreenPixels): Area {
  const x = clamp(left + Math.round(by.x), 0, screen.width - (right - left));
  const y = clamp(top + Math.round(by.y), 0, screen.height - (bottom - top));
  return [x, y, x + right - left, y + bottom - top];
}

/** Moves the right lower corner of an area. */
export function resized([left, top, right, bottom]: Area, by: Point, screen: ScreenPixels): Area {
  return [
    left,
    top,
    clamp(right + Math.round(by.x), left + 1, screen.width),
    clamp(bottom + Math.round(by.y), top + 1, screen.height),
  ];
}

/** Replaces one of the edges of an area, and keeps it a rectangle within the screen. */
export function withEdge(area: Area, edge: number, value: number, screen: ScreenPixels): Area {
  const next = area.map((old, at) => (at === edge ? value : old));
  const [left = 0, top = 0, right = 1, bottom = 1] = next;
  const x = clamp(left, 0, screen.width - 1);
  const y = clamp(top, 0, screen.height - 1);
  return [x, y, clamp(right, x + 1, screen.width), clamp(bottom, y + 1, screen.height)];
}

/** A new area in the middle of the screen. */
export function middle({ width, height }: ScreenPixels): Area {
  const [x, y] = [Math.floor((width - NEW_PX) / 2), Math.floor((height - NEW_PX) / 2)];
  return [
    Math.max(x, 0),
    Math.max(y, 0),
    Math.min(x + NEW_PX, width),
    Math.min(y + NEW_PX, height),
  ];
}

export function isSame(one: readonly Area[], other: readonly Area[]): boolean {
  return JSON.stringify(one) === JSON.stringify(other);
}

function clamp(value: number, low: number, high: number): number {
  return Math.min(Math.max(value, low), high);
}
