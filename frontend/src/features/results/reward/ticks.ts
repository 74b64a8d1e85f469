/** Tick positions of an axis. */

const STEPS = [1, 2, 5];

/** Returns at most `most` integers from `low` to `high`, evenly spaced by 1, 2 or 5 times 10^n. */
export function wholeTicks(low: number, high: number, most: number): number[] {
  for (let power = 1; power <= high - low || power === 1; power *= 10) {
    for (const distance of STEPS.map((step) => step * power)) {
      const first = Math.ceil(low / distance);
      const n = Math.floor(high / distance) - first + 1;
      if (n <= most) return Array.from({ length: n }, (_, index) => (first + index) * distance);
    }
  }
  return [];
}

/** Returns both ends and the middle of a range; a single tick if they are equal. */
export function endTicks(low: number, high: number): number[] {
  return low === high ? [low] : [low, (low + high) / 2, high];
}
