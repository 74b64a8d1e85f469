import { describe, expect, it } from "vitest";

import { readFrame, writeAck, writeInput } from "@/features/play/stream/binary-messages";
import { CodecError, ScreenDecoder } from "@/lib/game/codec";

import { bytesOf, sha256, vectors } from "../../../support/protocol-vectors";

describe("frames of the server", () => {
  it("decode to the screens that were sent", () => {
    const decoder = new ScreenDecoder({ width: 160, height: 210, palette: [] });
    for (const vector of vectors.frames) {
      const message = readFrame(bytesOf(vector.base64));
      expect(message).toMatchObject({
        isKey: vector.key,
        sequence: vector.sequence,
        frame: vector.frame,
        inputSequence: vector.input_sequence,
        marks: Uint8Array.of(vector.formation.left + 96, vector.formation.top),
        hasCounted: vector.shot,
      });
      decoder.apply(message.payload, message.isKey);
      expect(sha256(decoder.pixels)).toBe(vector.screen_sha256);
    }
    expect(new Set(vectors.frames.map(({ shot }) => shot))).toEqual(new Set([true, false]));
  });

  it("are refused when they are cut short", () => {
    expect(() => readFrame(new ArrayBuffer(16))).toThrow(CodecError);
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

  it("hold up to 24 buttons", () => {
    const written = new DataView(writeInput(0x81_02_03, 7));
    expect([written.getUint8(1), written.getUint16(2, true)]).toEqual([0x03, 0x8102]);
  });
});
