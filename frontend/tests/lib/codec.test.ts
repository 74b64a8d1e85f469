import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import { resolve } from "node:path";

import { zlibSync } from "fflate";
import fc from "fast-check";
import { describe, expect, it } from "vitest";

import {
  CodecError,
  readFrame,
  RecordedFrames,
  SCREEN_BYTES,
  ScreenDecoder,
  writeAck,
  writeInput,
} from "@/lib/codec";

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

/** Written by the server's tests: what its end of the protocol sends and expects. */
const vectors = JSON.parse(
  readFileSync(resolve(import.meta.dirname, "../../../tests/data/protocol-vectors.json"), "utf8"),
) as Vectors;

function bytesOf(base64: string): ArrayBuffer {
  return new Uint8Array(Buffer.from(base64, "base64")).buffer;
}

function sha256(pixels: Uint8Array): string {
  return createHash("sha256").update(pixels).digest("hex");
}

describe("frames of the server", () => {
  it("decode to the screens that were sent", () => {
    const decoder = new ScreenDecoder();
    for (const vector of vectors.frames) {
      const message = readFrame(bytesOf(vector.base64));
      expect(message).toMatchObject({
        isKey: vector.key,
        sequence: vector.sequence,
        frame: vector.frame,
        inputSequence: vector.input_sequence,
        formation: vector.formation,
        isShot: vector.shot,
      });
      decoder.apply(message.payload, message.isKey);
      expect(sha256(decoder.pixels)).toBe(vector.screen_sha256);
    }
    expect(new Set(vectors.frames.map(({ shot }) => shot))).toEqual(new Set([true, false]));
  });

  it("place the aliens left of the screen where their first columns are gone", () => {
    const data = new Uint8Array(bytesOf(vectors.frames[0]?.base64 ?? ""));
    data[2] = 0;
    expect(readFrame(data.buffer).formation.left).toBe(-96);
    data[2] = 255;
    expect(readFrame(data.buffer).formation.left).toBe(159);
  });

  it("are refused when they are cut short", () => {
    expect(() => readFrame(new ArrayBuffer(16))).toThrow(CodecError);
    const whole = readFrame(bytesOf(vectors.frames[0]?.base64 ?? ""));
    expect(() => new ScreenDecoder().apply(whole.payload.slice(0, 20), true)).toThrow(CodecError);
  });

  it("are refused when they are of another size", () => {
    const small = zlibSync(new Uint8Array(100));
    expect(() => new ScreenDecoder().apply(small, true)).toThrow("Expected 33600 pixels");
  });

  it("come back from any screens, whichever are key frames", () => {
    const screen = fc.uint8Array({ minLength: 40, maxLength: 40 });
    fc.assert(
      fc.property(
        fc.array(fc.tuple(screen, fc.boolean()), { minLength: 1, maxLength: 5 }),
        (all) => {
          const decoder = new ScreenDecoder();
          let before = new Uint8Array(SCREEN_BYTES);
          all.forEach(([part, wantsKey], index) => {
            const isKey = wantsKey || index === 0;
            const now = new Uint8Array(SCREEN_BYTES);
            now.set(part, index * 40);
            const sent = isKey ? now : now.map((value, i) => value ^ (before[i] ?? 0));
            decoder.apply(zlibSync(sent, { level: 1 }), isKey);
            expect(sha256(decoder.pixels)).toBe(sha256(now));
            before = now;
          });
        },
      ),
      { numRuns: 20 },
    );
  });
});

describe("messages to the server", () => {
  it("are the bytes that it expects", () => {
    const binary = vectors.client.filter(({ message }) => ["input", "ack"].includes(message.type));
    expect(binary.length).toBeGreaterThan(2);
    for (const { message, base64 } of binary) {
      const written =
        message.type === "input"
          ? writeInput(message.keys ?? 0, message.sequence)
          : writeAck(message.sequence, message.latency_ms ?? null);
      expect(Buffer.from(written).toString("base64")).toBe(base64);
    }
  });
});

describe("the frames of a recording", () => {
  const { base64, n_frames, screen_sha256 } = vectors.frames_file;
  const known = Object.entries(screen_sha256).map(([frame, sha]) => [Number(frame), sha] as const);

  it("are those that were recorded, in order", () => {
    const frames = new RecordedFrames(bytesOf(base64));
    expect(frames.last).toBe(n_frames);
    for (const [frame, sha] of known) expect(sha256(frames.show(frame))).toBe(sha);
  });

  it("are the same in whatever order they are asked for", () => {
    const frames = new RecordedFrames(bytesOf(base64));
    fc.assert(
      fc.property(fc.constantFrom(...known), ([frame, sha]) => {
        expect(sha256(frames.show(frame))).toBe(sha);
      }),
    );
  });

  it("hold at both ends", () => {
    const frames = new RecordedFrames(bytesOf(base64));
    expect(sha256(frames.show(-5))).toBe(sha256(frames.show(0)));
    expect(sha256(frames.show(n_frames + 9))).toBe(sha256(frames.show(n_frames)));
  });

  it("are refused when the file is another one, or incomplete", () => {
    expect(() => new RecordedFrames(new ArrayBuffer(64))).toThrow("not a file of frames");
    const cut = bytesOf(base64).slice(0, -2000);
    expect(() => new RecordedFrames(cut)).toThrow();
  });
});
