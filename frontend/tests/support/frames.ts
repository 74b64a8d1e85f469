/** Generates the file of a recording's frames. */
import { zlibSync } from "fflate";

const SCREEN_BYTES = 160 * 210;

/** A file of so many frames after the start's screen; each shows the number of its frame. */
export function framesFile(nFrames: number): ArrayBuffer {
  const header = new TextEncoder().encode(
    JSON.stringify({
      width: 160,
      height: 210,
      palette: Array.from({ length: 256 }, (_, value) => [value, value, value]),
      frame_rate_hz: 60,
      n_frames: nFrames,
      key_every: 1,
    }),
  );
  const frames = Array.from({ length: nFrames + 1 }, (_, frame) =>
    zlibSync(new Uint8Array(SCREEN_BYTES).fill(frame % 256)),
  );
  const parts: Uint8Array[] = [new TextEncoder().encode("TRILFRM1"), u32(header.length), header];
  for (const frame of frames) parts.push(u32(frame.length), new Uint8Array([1]), frame);
  const file = new Uint8Array(parts.reduce((sum, part) => sum + part.length, 0));
  let at = 0;
  for (const part of parts) {
    file.set(part, at);
    at += part.length;
  }
  return file.buffer;
}

function u32(value: number): Uint8Array {
  const bytes = new Uint8Array(4);
  new DataView(bytes.buffer).setUint32(0, value, true);
  return bytes;
}
