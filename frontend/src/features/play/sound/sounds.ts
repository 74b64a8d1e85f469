/** Sound effects, synthesized in the browser; not the game's own. */

type SoundName = "shot" | "target" | "stray" | "end";

/** A tone that glides from one frequency to another. */
interface Tone {
  readonly wave: OscillatorType;
  readonly fromHz: number;
  readonly toHz: number;
  readonly delayS: number;
  readonly durationS: number;
}

export const SOUNDS: Readonly<Record<SoundName, readonly Tone[]>> = {
  shot: [{ wave: "square", fromHz: 900, toHz: 220, delayS: 0, durationS: 0.09 }],
  target: [
    { wave: "triangle", fromHz: 660, toHz: 660, delayS: 0, durationS: 0.08 },
    { wave: "triangle", fromHz: 990, toHz: 990, delayS: 0.08, durationS: 0.14 },
  ],
  stray: [{ wave: "sawtooth", fromHz: 180, toHz: 90, delayS: 0, durationS: 0.18 }],
  end: [{ wave: "triangle", fromHz: 440, toHz: 110, delayS: 0, durationS: 0.5 }],
};

const LOUDNESS = 0.07;
/** An exponential ramp cannot end at 0. */
const SILENCE = 0.0001;

/** Plays sounds once the browser allows it: audio needs a user gesture first. */
export class Sounds {
  private readonly context: AudioContext;

  constructor(context: AudioContext) {
    this.context = context;
  }

  play(name: SoundName): void {
    if (this.context.state !== "running") {
      // A late sound would be wrong: skip this one and resume for the next.
      this.context.resume().catch(() => undefined);
      return;
    }
    SOUNDS[name].forEach((tone) => this.playTone(tone));
  }

  close(): void {
    this.context.close().catch(() => undefined);
  }

  private playTone({ wave, fromHz, toHz, delayS, durationS }: Tone): void {
    const { context } = this;
    const start = context.currentTime + delayS;
    const end = start + durationS;
    const oscillator = context.createOscillator();
    oscillator.type = wave;
    oscillator.frequency.setValueAtTime(fromHz, start);
    oscillator.frequency.exponentialRampToValueAtTime(toHz, end);
    const gain = context.createGain();
    gain.gain.setValueAtTime(LOUDNESS, start);
    gain.gain.exponentialRampToValueAtTime(SILENCE, end);
    oscillator.connect(gain).connect(context.destination);
    oscillator.start(start);
    oscillator.stop(end);
  }
}
