/** The binary messages of the play protocol (docs/protocol.md): frames, inputs, acknowledgements. */
import type { FrameInfo } from "@/games/view";
import { CodecError } from "@/lib/game/codec";

const FRAME_TYPE = 1;
const FRAME_HEADER_BYTES = 16;
const KEY_FRAME_FLAG = 1;
const COUNTED_FLAG = 2;
const MARKS_AT = 2;
const MARKS_BYTES = 2;
const INPUT_TYPE = 1;
const ACK_TYPE = 2;

export interface FrameMessage extends FrameInfo {
  readonly isKey: boolean;
  /** Counts from 1 within a connection. */
  readonly sequence: number;
  /** The newest input that the game had executed by this frame. */
  readonly inputSequence: number;
  readonly payload: Uint8Array;
}

/**
 * Reads a FRAME message.
 *
 * @throws {CodecError} It is too short, or of another type.
 */
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
    hasCounted: (flags & COUNTED_FLAG) !== 0,
    marks: new Uint8Array(message, MARKS_AT, MARKS_BYTES),
    sequence: view.getUint32(4, true),
    frame: view.getUint32(8, true),
    inputSequence: view.getUint32(12, true),
    payload: new Uint8Array(message, FRAME_HEADER_BYTES),
  };
}

/** Writes an INPUT message: the buttons currently held, as bits. */
export function writeInput(buttons: number, inputSequence: number): ArrayBuffer {
  const message = new ArrayBuffer(8);
  const view = new DataView(message);
  view.setUint8(0, INPUT_TYPE);
  view.setUint8(1, buttons & 0xff);
  view.setUint16(2, buttons >>> 8, true);
  view.setUint32(4, inputSequence, true);
  return message;
}

const LATENCY_UNITS_PER_MS = 10;
const LONGEST_LATENCY = 0xffff;

/**
 * Writes an ACK message: a frame has been drawn.
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
