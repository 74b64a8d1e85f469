/** Playback of a recording against the clock, independent of React and the canvas. */

export const SPEEDS = [0.25, 0.5, 1, 2, 4] as const;

interface PlaybackState {
  readonly frame: number;
  readonly playing: boolean;
  readonly speed: number;
}

interface Clock {
  /** Milliseconds, monotonic. */
  now(): number;
  request(callback: () => void): number;
  cancel(id: number): void;
}

const browserClock: Clock = {
  now: () => performance.now(),
  request: (callback) => requestAnimationFrame(callback),
  cancel: (id) => cancelAnimationFrame(id),
};

/** The position in a recording and whether it is playing. */
export class Playback {
  private state: PlaybackState = { frame: 0, playing: false, speed: 1 };
  private readonly listeners = new Set<() => void>();
  private readonly last: number;
  private readonly rateHz: number;
  private readonly loop: boolean;
  private readonly clock: Clock;
  private ticket: number | null = null;
  /** The frame and time from which the current frame is computed. */
  private origin = { frame: 0, time: 0 };

  constructor(last: number, rateHz: number, { loop = false, clock = browserClock } = {}) {
    this.last = last;
    this.rateHz = rateHz;
    this.loop = loop;
    this.clock = clock;
  }

  readonly subscribe = (listener: () => void): (() => void) => {
    this.listeners.add(listener);
    return () => this.listeners.delete(listener);
  };

  readonly snapshot = (): PlaybackState => this.state;

  /** Starts playing, from the beginning if the end was reached. */
  play(): void {
    const frame = this.state.frame >= this.last ? 0 : this.state.frame;
    this.origin = { frame, time: this.clock.now() };
    this.update({ frame, playing: true });
    this.schedule();
  }

  pause(): void {
    if (this.ticket !== null) this.clock.cancel(this.ticket);
    this.ticket = null;
    this.update({ playing: false });
  }

  toggle(): void {
    if (this.state.playing) this.pause();
    else this.play();
  }

  /** Jumps to a frame, clamped, without changing whether it plays. */
  seek(frame: number): void {
    const to = Math.min(Math.max(Math.round(frame), 0), this.last);
    this.origin = { frame: to, time: this.clock.now() };
    this.update({ frame: to });
  }

  /** Pauses and moves by some frames. */
  step(frames: number): void {
    this.pause();
    this.seek(this.state.frame + frames);
  }

  setSpeed(speed: number): void {
    this.origin = { frame: this.state.frame, time: this.clock.now() };
    this.update({ speed });
  }

  /** Stops playback and drops the listeners. */
  dispose(): void {
    if (this.ticket !== null) this.clock.cancel(this.ticket);
    this.ticket = null;
    this.listeners.clear();
  }

  private schedule(): void {
    this.ticket ??= this.clock.request(() => {
      this.ticket = null;
      this.tick();
    });
  }

  private tick(): void {
    const { origin, last, loop } = this;
    const passed = ((this.clock.now() - origin.time) / 1000) * this.rateHz * this.state.speed;
    const frame = origin.frame + Math.floor(passed);
    if (frame <= last) {
      this.update({ frame });
    } else if (loop) {
      this.seek(0);
    } else {
      this.update({ frame: last, playing: false });
      return;
    }
    this.schedule();
  }

  private update(change: Partial<PlaybackState>): void {
    this.state = { ...this.state, ...change };
    this.listeners.forEach((listener) => listener());
  }
}
