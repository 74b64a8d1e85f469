/** Which keys steer the game, by their place on the keyboard (`KeyboardEvent.code`). */

/** Bits of the keys held, as the play protocol sends them. */
export const LEFT = 1;
export const RIGHT = 2;
export const FIRE = 4;

const GAME_KEYS: Readonly<Record<string, number>> = {
  ArrowLeft: LEFT,
  KeyA: LEFT,
  ArrowRight: RIGHT,
  KeyD: RIGHT,
  Space: FIRE,
  ArrowUp: FIRE,
  KeyW: FIRE,
};

/** Whether a key steers the game, so that the page must not scroll by it. */
export function isGameKey(code: string): boolean {
  return code in GAME_KEYS || code === "ArrowDown";
}

/** The keys (and touch buttons) held at the moment. */
export class HeldKeys {
  private readonly held = new Map<string, number>();

  /** A key goes down; returns whether the set of held keys changed for the game. */
  press(code: string): boolean {
    const bit = GAME_KEYS[code];
    return bit === undefined ? false : this.hold(code, bit);
  }

  /** Something named `name` holds a key, such as a finger on a button. */
  hold(name: string, bit: number): boolean {
    const before = this.bits;
    this.held.set(name, bit);
    return this.bits !== before;
  }

  release(name: string): boolean {
    const before = this.bits;
    this.held.delete(name);
    return this.bits !== before;
  }

  /** Everything is let go, as when the window loses the keyboard. */
  releaseAll(): boolean {
    const before = this.bits;
    this.held.clear();
    return before !== 0;
  }

  get bits(): number {
    let bits = 0;
    for (const bit of this.held.values()) bits |= bit;
    return bits;
  }
}
