/** Measures input latency and dropped frames. */

export interface LatencySummary {
  /** Number of presses timed. */
  readonly presses: number;
  /** From a key event to drawing the first frame that shows it, in ms; null without presses. */
  readonly p50Ms: number | null;
  readonly p95Ms: number | null;
  readonly drawn: number;
  /** Number of frames that were never drawn. */
  readonly dropped: number;
}

interface Press {
  readonly sequence: number;
  readonly atMs: number;
}

/** Times key presses and counts drawn and dropped frames. */
export class LatencyMeter {
  private readonly samples: number[] = [];
  private pending: Press[] = [];
  private lastFrame: number | null = null;
  private drawn = 0;
  private dropped = 0;

  /** Records a key press, by `performance.now()`, that was sent as an input. */
  press(sequence: number, atMs: number): void {
    this.pending.push({ sequence, atMs });
  }

  /** Drops pending presses: the game is paused or the connection new. */
  forget(): void {
    this.pending = [];
    this.lastFrame = null;
  }

  /**
   * Records that a frame was drawn.
   *
   * @param frame Its number in the game.
   * @param inputSequence The newest input executed by then.
   * @param nowMs The time by performance.now().
   * @returns Milliseconds since the earliest press that it is the first to show; null if none.
   */
  show(frame: number, inputSequence: number, nowMs: number): number | null {
    if (this.lastFrame !== null) {
      this.drawn += 1;
      this.dropped += Math.max(0, frame - this.lastFrame - 1);
    }
    this.lastFrame = frame;
    const [first] = this.pending;
    if (!first || first.sequence > inputSequence) return null;
    this.pending = this.pending.filter(({ sequence }) => sequence > inputSequence);
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

/** Returns the nearest-rank percentile of sorted values. */
function nearestRank(sorted: readonly number[], share: number): number | null {
  return sorted[Math.max(0, Math.ceil(share * sorted.length) - 1)] ?? null;
}
