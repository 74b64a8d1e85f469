/** Films of share pages, as docs/protocol.md describes them. */
import { unzlibSync } from "fflate";

import { screenBytes } from "@/lib/game/codec";
import type { ScreenFormat } from "@/lib/game/screen";

const MORE = 0x80;

/** A game's pictures, of which each says how it differs from the one before. */
export class Film {
  /** The number of the last frame; frame 0 is the screen at the start. */
  readonly last: number;
  private readonly framesPerPicture: number;
  private readonly bytes: Uint8Array;
  /** Where each picture begins. */
  private readonly begins: readonly number[];
  private readonly pixels: Uint8Array;
  /** The picture that is shown; -1 is a blank screen. */
  private at = -1;
  private offset = 0;

  constructor(format: ScreenFormat, content: Uint8Array, last: number, framesPerPicture = 1) {
    this.last = last;
    this.framesPerPicture = framesPerPicture;
    this.bytes = unzlibSync(content);
    this.pixels = new Uint8Array(screenBytes(format));
    const begins: number[] = [];
    while (this.offset < this.bytes.length) {
      begins.push(this.offset);
      for (let runs = this.number(); runs > 0; runs -= 1) {
        this.number();
        const length = this.number();
        this.offset += length;
      }
    }
    this.begins = begins;
  }

  /** Returns the pixels of a frame, clamped to the film; they are updated in place. */
  show(frame: number): Uint8Array {
    const picture = Math.floor(Math.max(frame, 0) / this.framesPerPicture);
    const target = Math.min(picture, this.begins.length - 1);
    // A difference leads back as it leads forward.
    while (this.at < target) this.apply((this.at += 1));
    while (this.at > target) this.apply(this.at--);
    return this.pixels;
  }

  private apply(picture: number): void {
    this.offset = this.begins[picture] ?? this.bytes.length;
    let at = 0;
    for (let runs = this.number(); runs > 0; runs -= 1) {
      at += this.number();
      for (let left = this.number(); left > 0; left -= 1) {
        this.pixels[at] = (this.pixels[at] ?? 0) ^ (this.bytes[this.offset] ?? 0);
        this.offset += 1;
        at += 1;
      }
    }
  }

  /** Reads a number in groups of seven bits, the lowest first. */
  private number(): number {
    let value = 0;
    for (let scale = 1; ; scale *= MORE) {
      const byte = this.bytes[this.offset] ?? 0;
      this.offset += 1;
      value += (byte % MORE) * scale;
      if (byte < MORE) return value;
    }
  }
}
