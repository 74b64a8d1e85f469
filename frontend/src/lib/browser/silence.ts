/** Notices that a connection went silent, which no event tells, and that the page stood still. */

const LOOK_EVERY_MS = 500;
/** As the server's (server/play/session/clock.py). */
const MAX_GAP_MS = 1000;

interface SilenceEvents {
  /** Nothing was heard for longer than the limit. */
  onSilence: () => void;
  /** Time jumped: the page or the whole machine was suspended, or too busy. */
  onJump?: (gapMs: number) => void;
}

export class SilenceWatch {
  private readonly events: SilenceEvents;
  private timer: ReturnType<typeof setInterval> | undefined;
  private limitMs = 0;
  private heardAt = 0;

  constructor(events: SilenceEvents) {
    this.events = events;
  }

  /** Watches from now on. */
  start(limitMs: number): void {
    this.stop();
    this.limitMs = limitMs;
    this.heardAt = performance.now();
    // Of the clocks only the date goes on while every machine sleeps.
    let lookedAt = Date.now();
    this.timer = setInterval(() => {
      const gapMs = Date.now() - lookedAt - LOOK_EVERY_MS;
      lookedAt = Date.now();
      if (gapMs > MAX_GAP_MS) {
        // What was received meanwhile has yet to be read.
        this.heardAt = performance.now();
        this.events.onJump?.(gapMs);
      } else if (performance.now() - this.heardAt > this.limitMs) {
        this.stop();
        this.events.onSilence();
      }
    }, LOOK_EVERY_MS);
  }

  /** Something was received; from then on silence may last so long. */
  heard(limitMs = this.limitMs): void {
    this.limitMs = limitMs;
    this.heardAt = performance.now();
  }

  stop(): void {
    clearInterval(this.timer);
  }
}
