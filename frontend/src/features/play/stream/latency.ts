/** How late a person sees what their keys do. Pure. */

/** How a game was seen so far. */
export interface LatencySummary {
  /** How many presses were timed. */
  readonly presses: number;
  /** From a key's event to the drawing of the first frame with it, in ms; null without presses. */
  readonly p50Ms: number | null;
  readonly p95Ms: number | null;
  readonly drawn: number;
  /** Frames of the game that were never drawn. */
  readonly dropped: number;
}

interface Press {
  readonly sequence: number;
  readonly atMs: number;
}

/** Times presses, and counts the frames that were drawn and left out. */
export class LatencyMeter {
  private readonly samples: number[] = [];
  private waiting: Press[] = [];
  private lastFrame: number | null = null;
  private drawn = 0;
  private dropped = 0;

  /** A key went down at a time by performance.now(), and was sent as this input. */
  press(sequence: number, atMs: number): void {
    this.waiting.push({ sequence, atMs });
  }

  /** The game stands still or the connection is new: what waits is not timed. */
  forget(): void {
    this.waiting = [];
    this.lastFrame = null;
  }

  /**
   * A frame was drawn.
   *
   * @param frame Its number in the game.
   * @param inputSequence The newest input that it was executed with.
   * @param nowMs The time by performance.now().
   * @returns The milliseconds since the earliest press that it is the first to show, or null.
   */
  show(frame: number, inputSequence: number, nowMs: number): number | null {
    if (this.lastFrame !== null) {
      this.drawn += 1;
      this.dropped += Math.max(0, frame - this.lastFrame - 1);
    }
    this.lastFrame = frame;
    const [first] = this.waiting;
    if (!first || first.sequence > inputSequence) return null;
    this.waiting = this.waiting.filter(({ sequence }) => sequence > inputSequence);
    const latency = Math.max(0, nowMs - first.atMs);
    this.samples.push(latency);
    return latency;
  }

  summary(): LatencySummary {
    const sorted = [...this.samples].sort((a, b) => a - b);
    return {
      presses: sorted.length,
      p50Ms: nearestRank(sorted, 0.5),
      p95Ms: nearestRank(sorted, 0.95),
      drawn: this.drawn,
      dropped: this.dropped,
    };
  }
}

/** The smallest value that so large a share of the sorted values does not exceed. */
function nearestRank(sorted: readonly number[], share: number): number | null {
  return sorted[Math.max(0, Math.ceil(share * sorted.length) - 1)] ?? null;
}
