/** Small sounds made by the browser itself; not the game's own. */

export type SoundName = "shot" | "target" | "stray" | "end";

/** A tone that glides from one frequency to another. */
interface Tone {
  readonly wave: OscillatorType;
  readonly fromHz: number;
  readonly toHz: number;
  readonly afterS: number;
  readonly lastsS: number;
}

export const SOUNDS: Readonly<Record<SoundName, readonly Tone[]>> = {
  shot: [{ wave: "square", fromHz: 900, toHz: 220, afterS: 0, lastsS: 0.09 }],
  target: [
    { wave: "triangle", fromHz: 660, toHz: 660, afterS: 0, lastsS: 0.08 },
    { wave: "triangle", fromHz: 990, toHz: 990, afterS: 0.08, lastsS: 0.14 },
  ],
  stray: [{ wave: "sawtooth", fromHz: 180, toHz: 90, afterS: 0, lastsS: 0.18 }],
  end: [{ wave: "triangle", fromHz: 440, toHz: 110, afterS: 0, lastsS: 0.5 }],
};

const LOUDNESS = 0.07;
/** A gain can't fall to nothing exponentially. */
const SILENCE = 0.0001;

/** Plays the sounds, if the browser lets it: before a person has done anything, none does. */
export class Sounds {
  private readonly context: AudioContext;

  constructor(context: AudioContext) {
    this.context = context;
  }

  play(name: SoundName): void {
    if (this.context.state !== "running") {
      // Played later it would be wrong; the next one may come through.
      this.context.resume().catch(() => undefined);
      return;
    }
    SOUNDS[name].forEach((tone) => this.playTone(tone));
  }

  close(): void {
    this.context.close().catch(() => undefined);
  }

  private playTone({ wave, fromHz, toHz, afterS, lastsS }: Tone): void {
    const { context } = this;
    const begins = context.currentTime + afterS;
    const ends = begins + lastsS;
    const oscillator = context.createOscillator();
    oscillator.type = wave;
    oscillator.frequency.setValueAtTime(fromHz, begins);
    oscillator.frequency.exponentialRampToValueAtTime(toHz, ends);
    const gain = context.createGain();
    gain.gain.setValueAtTime(LOUDNESS, begins);
    gain.gain.exponentialRampToValueAtTime(SILENCE, ends);
    oscillator.connect(gain).connect(context.destination);
    oscillator.start(begins);
    oscillator.stop(ends);
  }
}
