/** Test vectors of the play protocol, written by the server's tests. */
import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { resolve } from "node:path";

interface Vectors {
  frames: {
    base64: string;
    key: boolean;
    sequence: number;
    frame: number;
    input_sequence: number;
    formation: { left: number; top: number };
    shot: boolean;
    screen_sha256: string;
  }[];
  client: {
    message: { type: string; keys?: number; sequence: number; latency_ms?: number };
    base64: string;
  }[];
  frames_file: { base64: string; n_frames: number; screen_sha256: Record<string, string> };
}

export const vectors = JSON.parse(
  readFileSync(resolve(import.meta.dirname, "../../../tests/data/protocol-vectors.json"), "utf8"),
) as Vectors;

export function bytesOf(base64: string): ArrayBuffer {
  return new Uint8Array(Buffer.from(base64, "base64")).buffer;
}

export function sha256(pixels: Uint8Array): string {
  return createHash("sha256").update(pixels).digest("hex");
}
