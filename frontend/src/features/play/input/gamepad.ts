/** Reads gamepads in the standard layout. */
import { FIRE, LEFT, RIGHT } from "./keys";

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
const FIRES = [PAD.bottom, PAD.right, PAD.left, PAD.top];
const REWINDS = [4, 5, 6, 7];
const D_PAD_LEFT = 14;
const D_PAD_RIGHT = 15;
/** A released stick rarely rests at exactly 0. */
const DEAD_ZONE = 0.4;

export interface PadState {
  /** The game's keys held. */
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

  /** Reads the gamepads. One that is missing has to be seen at rest anew. */
  read(pads: readonly (Pad | null)[]): PadState {
    const rested = new Map<number, string>();
    const pressed = new Set<number>();
    let bits = 0;
    for (const pad of pads) {
      if (!pad?.connected || pad.mapping !== "standard") continue;
      const x = pad.axes[0] ?? 0;
      if (Math.abs(x) <= DEAD_ZONE || this.rested.get(pad.index) === pad.id) {
        rested.set(pad.index, pad.id);
        if (x < -DEAD_ZONE) bits |= LEFT;
        if (x > DEAD_ZONE) bits |= RIGHT;
      }
      pad.buttons.forEach((button, number) => {
        if (button.pressed) pressed.add(number);
      });
    }
    this.rested = rested;
    return stateOf(bits, pressed);
  }
}

function stateOf(stick: number, pressed: ReadonlySet<number>): PadState {
  let bits = stick;
  if (pressed.has(D_PAD_LEFT)) bits |= LEFT;
  if (pressed.has(D_PAD_RIGHT)) bits |= RIGHT;
  if (FIRES.some((number) => pressed.has(number))) bits |= FIRE;
  return { bits, rewind: REWINDS.some((number) => pressed.has(number)), pressed };
}

/** Returns the buttons that were pressed between two readings. */
export function newlyPressed(before: PadState, now: PadState): readonly number[] {
  return [...now.pressed].filter((number) => !before.pressed.has(number));
}
