/** Decodes screens: pixels, XORed with those of the previous screen, compressed with zlib. */
import { unzlibSync } from "fflate";

import type { ScreenFormat } from "./screen";

const WORD_BYTES = 4;

/** Returns the bytes of a screen: one a pixel with a palette, else red, green and blue. */
export function screenBytes({ width, height, palette }: ScreenFormat): number {
  return width * height * (palette ? 1 : 3);
}

/** The bytes do not follow the protocol; the rest of the connection or file is unreadable. */
export class CodecError extends Error {
  override name = "CodecError";
}

/** Holds the current screen and applies the differences to it. */
export class ScreenDecoder {
  private readonly words: Uint32Array;
  private readonly packed: Uint32Array;
  /** Palette indices or colours, row by row from the top; updated in place by `apply`. */
  readonly pixels: Uint8Array;

  constructor(format: ScreenFormat) {
    const bytes = screenBytes(format);
    this.words = new Uint32Array(Math.ceil(bytes / WORD_BYTES));
    // With room for what is too long, which would be cut off otherwise.
    this.packed = new Uint32Array(this.words.length + 1);
    this.pixels = new Uint8Array(this.words.buffer, 0, bytes);
  }

  /**
   * Applies one frame; a key frame replaces the screen.
   *
   * @throws {CodecError} The payload is corrupt or has another size.
   */
  apply(payload: Uint8Array, isKey: boolean): void {
    const { length } = this.pixels;
    const out = new Uint8Array(this.packed.buffer);
    let unpacked: Uint8Array;
    try {
      unpacked = unzlibSync(payload, { out });
    } catch (error) {
      throw new CodecError("A frame could not be unpacked.", { cause: error });
    }
    if (unpacked.length !== length) {
      throw new CodecError(`Expected ${length} bytes in a frame, got ${unpacked.length}.`);
    }
    if (unpacked.buffer !== out.buffer) out.set(unpacked);
    if (isKey) {
      this.words.set(this.packed.subarray(0, this.words.length));
      return;
    }
    const { words, packed } = this;
    for (let i = 0; i < words.length; i += 1) words[i] = (words[i] ?? 0) ^ (packed[i] ?? 0);
  }
}

const FILE_MAGIC = "TRILFRM1";
const FILE_FRAME_HEADER_BYTES = 5;
const KEY_FRAME_FLAG = 1;

interface FramesHeader extends ScreenFormat {
  readonly frame_rate_hz: number;
  readonly n_frames: number;
  readonly key_every: number;
}

/** The screens of a recording, decoded on demand. */
export class RecordedFrames {
  readonly header: FramesHeader;
  private readonly frames: { readonly payload: Uint8Array; readonly isKey: boolean }[] = [];
  private readonly decoder: ScreenDecoder;
  private at = -1;

  constructor(body: ArrayBuffer) {
    const magic = new TextDecoder().decode(body.slice(0, FILE_MAGIC.length));
    if (magic !== FILE_MAGIC) throw new CodecError("This is not a file of frames.");
    const view = new DataView(body);
    const headerLength = view.getUint32(FILE_MAGIC.length, true);
    let offset = FILE_MAGIC.length + 4;
    const json = new TextDecoder().decode(new Uint8Array(body, offset, headerLength));
    this.header = JSON.parse(json) as FramesHeader;
    this.decoder = new ScreenDecoder(this.header);
    offset += headerLength;
    while (offset < body.byteLength) {
      const length = view.getUint32(offset, true);
      const flags = view.getUint8(offset + 4);
      offset += FILE_FRAME_HEADER_BYTES;
      this.frames.push({
        payload: new Uint8Array(body, offset, length),
        isKey: (flags & KEY_FRAME_FLAG) !== 0,
      });
      offset += length;
    }
    if (this.frames.length !== this.header.n_frames + 1 || !this.frames[0]?.isKey) {
      throw new CodecError("The file of frames is incomplete.");
    }
  }

  /** Number of the last frame; frame 0 is the screen at the start. */
  get last(): number {
    return this.frames.length - 1;
  }

  /** Decodes a frame, clamped to the recording, and returns its pixels. */
  show(frame: number): Uint8Array {
    const target = Math.min(Math.max(Math.trunc(frame), 0), this.last);
    let from = target;
    while (from > 0 && !this.frames[from]?.isKey) from -= 1;
    const next = this.at <= target && this.at >= from ? this.at + 1 : from;
    for (let i = next; i <= target; i += 1) {
      const encoded = this.frames[i];
      if (encoded) this.decoder.apply(encoded.payload, encoded.isKey);
    }
    this.at = target;
    return this.decoder.pixels;
  }
}
