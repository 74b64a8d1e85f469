/**
 * The browser's end of the play protocol (docs/protocol.md): frames in, inputs and
 * acknowledgements out. A screen travels as palette values XOR the last screen sent, zlib packed.
 */
import { unzlibSync } from "fflate";

import type { Formation } from "./formation";

export const SCREEN_WIDTH = 160;
export const SCREEN_HEIGHT = 210;
export const SCREEN_BYTES = SCREEN_WIDTH * SCREEN_HEIGHT;

const FRAME_TYPE = 1;
const FRAME_HEADER_BYTES = 16;
const KEY_FRAME_FLAG = 1;
const SHOT_FLAG = 2;
/** Added to the formation's left edge on its way, which can lie left of the screen. */
const LEFT_BIAS = 96;
const INPUT_TYPE = 1;
const ACK_TYPE = 2;

/** The bytes are not what the protocol says; the connection or file can't be read on. */
export class CodecError extends Error {
  override name = "CodecError";
}

export interface FrameMessage {
  readonly isKey: boolean;
  /** Counts from 1 in each connection. */
  readonly sequence: number;
  /** The game's frame; 0 is the start's screen. */
  readonly frame: number;
  /** The newest input that a frame of the game was executed with. */
  readonly inputSequence: number;
  /** Where the aliens stand on this screen. */
  readonly formation: Formation;
  /** Whether a missile has left the cannon since the screen before. */
  readonly isShot: boolean;
  readonly payload: Uint8Array;
}

/** Reads a FRAME message. */
export function readFrame(message: ArrayBuffer): FrameMessage {
  if (message.byteLength <= FRAME_HEADER_BYTES) {
    throw new CodecError(`A frame of ${message.byteLength} bytes is too short.`);
  }
  const view = new DataView(message);
  const type = view.getUint8(0);
  if (type !== FRAME_TYPE) throw new CodecError(`Expected a frame, got message type ${type}.`);
  const flags = view.getUint8(1);
  return {
    isKey: (flags & KEY_FRAME_FLAG) !== 0,
    isShot: (flags & SHOT_FLAG) !== 0,
    formation: { left: view.getUint8(2) - LEFT_BIAS, top: view.getUint8(3) },
    sequence: view.getUint32(4, true),
    frame: view.getUint32(8, true),
    inputSequence: view.getUint32(12, true),
    payload: new Uint8Array(message, FRAME_HEADER_BYTES),
  };
}

/** Writes an INPUT message: the keys held now. */
export function writeInput(keys: number, inputSequence: number): ArrayBuffer {
  const message = new ArrayBuffer(8);
  const view = new DataView(message);
  view.setUint8(0, INPUT_TYPE);
  view.setUint8(1, keys);
  view.setUint32(4, inputSequence, true);
  return message;
}

const LATENCY_UNITS_PER_MS = 10;
const LONGEST_LATENCY = 0xffff;

/**
 * Writes an ACK message: this frame has been drawn.
 *
 * @param latencyMs Time since the key's event, if it is the first frame drawn with a key pressed.
 */
export function writeAck(sequence: number, latencyMs: number | null = null): ArrayBuffer {
  const message = new ArrayBuffer(8);
  const view = new DataView(message);
  view.setUint8(0, ACK_TYPE);
  if (latencyMs !== null) {
    const units = Math.max(1, Math.round(latencyMs * LATENCY_UNITS_PER_MS));
    view.setUint16(2, Math.min(units, LONGEST_LATENCY), true);
  }
  view.setUint32(4, sequence, true);
  return message;
}

/** Holds the current screen and applies the differences that arrive. */
export class ScreenDecoder {
  private readonly words = new Uint32Array(SCREEN_BYTES / 4);
  private readonly packed = new Uint32Array(SCREEN_BYTES / 4);
  /** Palette values, row by row from the top; changed in place by `apply`. */
  readonly pixels = new Uint8Array(this.words.buffer);

  /** Unpacks one screen; a key frame stands on its own. */
  apply(payload: Uint8Array, isKey: boolean): void {
    const out = new Uint8Array(this.packed.buffer);
    let unpacked: Uint8Array;
    try {
      unpacked = unzlibSync(payload, { out });
    } catch (error) {
      throw new CodecError("A frame could not be unpacked.", { cause: error });
    }
    if (unpacked.length !== SCREEN_BYTES) {
      throw new CodecError(`Expected ${SCREEN_BYTES} pixels in a frame, got ${unpacked.length}.`);
    }
    if (unpacked.buffer !== out.buffer) out.set(unpacked);
    if (isKey) {
      this.words.set(this.packed);
      return;
    }
    const { words, packed } = this;
    for (let i = 0; i < words.length; i += 1) words[i] = (words[i] ?? 0) ^ (packed[i] ?? 0);
  }
}

const FILE_MAGIC = "TRILFRM1";
const FILE_FRAME_HEADER_BYTES = 5;

interface FramesHeader {
  readonly width: number;
  readonly height: number;
  readonly palette: readonly (readonly [number, number, number])[];
  readonly frame_rate_hz: number;
  readonly n_frames: number;
  readonly key_every: number;
}

/** All screens of a recording; `show` unpacks any of them. */
export class RecordedFrames {
  readonly header: FramesHeader;
  private readonly frames: { readonly payload: Uint8Array; readonly isKey: boolean }[] = [];
  private readonly decoder = new ScreenDecoder();
  private at = -1;

  constructor(body: ArrayBuffer) {
    const magic = new TextDecoder().decode(body.slice(0, FILE_MAGIC.length));
    if (magic !== FILE_MAGIC) throw new CodecError("This is not a file of frames.");
    const view = new DataView(body);
    const headerLength = view.getUint32(FILE_MAGIC.length, true);
    let offset = FILE_MAGIC.length + 4;
    const json = new TextDecoder().decode(new Uint8Array(body, offset, headerLength));
    this.header = JSON.parse(json) as FramesHeader;
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

  /** The last frame's number; frame 0 is the start's screen. */
  get last(): number {
    return this.frames.length - 1;
  }

  /** Unpacks a frame (clamped to those there are) and returns its palette values. */
  show(frame: number): Uint8Array {
    const wanted = Math.min(Math.max(Math.trunc(frame), 0), this.last);
    let from = wanted;
    while (from > 0 && !this.frames[from]?.isKey) from -= 1;
    const next = this.at <= wanted && this.at >= from ? this.at + 1 : from;
    for (let i = next; i <= wanted; i += 1) {
      const one = this.frames[i];
      if (one) this.decoder.apply(one.payload, one.isKey);
    }
    this.at = wanted;
    return this.decoder.pixels;
  }
}
