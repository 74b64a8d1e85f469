/** Reads gamepads in the standard layout. */
import { buttonBit } from "./keys";

/** The part of a `Gamepad` that is read. */
export interface Pad {
  readonly id: string;
  readonly index: number;
  readonly connected: boolean;
  /** "standard" if its buttons and axes are where the standard layout has them. */
  readonly mapping: string;
  readonly axes: readonly number[];
  readonly buttons: readonly { readonly pressed: boolean }[];
}

/** Button numbers of the standard layout (https://w3c.github.io/gamepad/#remapping). */
export const PAD = { bottom: 0, right: 1, left: 2, top: 3, start: 9 } as const;
const FACES = [PAD.bottom, PAD.right, PAD.left, PAD.top];
const REWINDS = [4, 5, 6, 7];
/** Numbers of the D-pad's buttons, by the directions of a game. */
const D_PAD: readonly (readonly [number: number, direction: string])[] = [
  [12, "up"],
  [13, "down"],
  [14, "left"],
  [15, "right"],
];
/** A released stick rarely rests at exactly 0. */
const DEAD_ZONE = 0.4;

export interface PadState {
  /** The game's buttons held. */
  readonly bits: number;
  readonly rewind: boolean;
  /** Numbers of the buttons pressed. */
  readonly pressed: ReadonlySet<number>;
}

export const NO_PAD: PadState = { bits: 0, rewind: false, pressed: new Set() };

/**
 * Combines the states of all gamepads in the standard layout. Of others nobody knows which axis is a
 * stick and which a trigger, whose rest is at an end.
 */
export class Pads {
  /** Those whose stick was seen at rest, by index; before, an axis may be stuck or not yet read. */
  private rested = new Map<number, string>();

  /**
   * Reads the gamepads. One that is missing has to be seen at rest anew.
   *
   * @param buttons The game's.
   */
  read(pads: readonly (Pad | null)[], buttons: readonly string[]): PadState {
    const rested = new Map<number, string>();
    const pressed = new Set<number>();
    let bits = 0;
    for (const pad of pads) {
      if (!pad?.connected || pad.mapping !== "standard") continue;
      const [x = 0, y = 0] = pad.axes;
      const rests = Math.abs(x) <= DEAD_ZONE && Math.abs(y) <= DEAD_ZONE;
      if (rests || this.rested.get(pad.index) === pad.id) {
        rested.set(pad.index, pad.id);
        if (Math.abs(x) > DEAD_ZONE) bits |= buttonBit(buttons, x < 0 ? "left" : "right");
        if (Math.abs(y) > DEAD_ZONE) bits |= buttonBit(buttons, y < 0 ? "up" : "down");
      }
      pad.buttons.forEach((button, number) => {
        if (button.pressed) pressed.add(number);
      });
    }
    this.rested = rested;
    return stateOf(bits, pressed, buttons);
  }
}

function stateOf(
  stick: number,
  pressed: ReadonlySet<number>,
  buttons: readonly string[],
): PadState {
  let bits = stick;
  for (const [number, direction] of D_PAD)
    if (pressed.has(number)) bits |= buttonBit(buttons, direction);
  for (const [number, button] of facesOf(buttons))
    if (pressed.has(number)) bits |= buttonBit(buttons, button);
  return { bits, rewind: REWINDS.some((number) => pressed.has(number)), pressed };
}

/** Returns what each face button is in a game: all of them fire, or they are its other buttons. */
function facesOf(buttons: readonly string[]): readonly (readonly [number, string])[] {
  if (buttons.includes("fire")) return FACES.map((number) => [number, "fire"]);
  const others = buttons.filter((name) => D_PAD.every(([, direction]) => direction !== name));
  return FACES.flatMap((number, at) => {
    const name = others[at];
    return name === undefined ? [] : [[number, name] as const];
  });
}

/** Returns the buttons that were pressed between two readings. */
export function newlyPressed(before: PadState, now: PadState): readonly number[] {
  return [...now.pressed].filter((number) => !before.pressed.has(number));
}
