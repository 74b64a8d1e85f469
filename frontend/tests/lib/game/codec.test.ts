import { zlibSync } from "fflate";
import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { CodecError, RecordedFrames, ScreenDecoder } from "@/lib/game/codec";

import { bytesOf, sha256, vectors } from "../../support/protocol-vectors";

const CONSOLE = { width: 160, height: 210, palette: [] };
const SCREEN_BYTES = 160 * 210;

describe("a screen", () => {
  it("is refused when it has another size", () => {
    const small = zlibSync(new Uint8Array(100));
    expect(() => new ScreenDecoder(CONSOLE).apply(small, true)).toThrow("Expected 33600 bytes");
  });

  it("is refused when its bytes are cut short", () => {
    const whole = zlibSync(new Uint8Array(SCREEN_BYTES));
    expect(() => new ScreenDecoder(CONSOLE).apply(whole.slice(0, 20), true)).toThrow(CodecError);
  });

  it("has three bytes a pixel where there is no palette, and any size", () => {
    const format = { width: 7, height: 3, palette: null };
    const decoder = new ScreenDecoder(format);
    const colours = Uint8Array.from({ length: 63 }, (_, at) => at * 3);
    decoder.apply(zlibSync(colours), true);
    decoder.apply(zlibSync(new Uint8Array(63).fill(1)), false);
    expect([...decoder.pixels]).toEqual([...colours].map((value) => value ^ 1));
    expect(() => decoder.apply(zlibSync(new Uint8Array(64)), true)).toThrow("Expected 63 bytes");
  });

  it("survives coding, whichever screens are key frames", () => {
    const screen = fc.uint8Array({ minLength: 40, maxLength: 40 });
    fc.assert(
      fc.property(
        fc.array(fc.tuple(screen, fc.boolean()), { minLength: 1, maxLength: 5 }),
        (all) => {
          const decoder = new ScreenDecoder(CONSOLE);
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
