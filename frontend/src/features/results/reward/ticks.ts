/** Where the marks of an axis are. */

const STEPS = [1, 2, 5];

/** Whole numbers from low to high with equal, round distances; at most so many. */
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

/** Both ends and the middle of a range of measured values; one mark where they are the same. */
export function endTicks(low: number, high: number): number[] {
  return low === high ? [low] : [low, (low + high) / 2, high];
}
