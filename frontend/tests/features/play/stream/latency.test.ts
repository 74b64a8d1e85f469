import fc from "fast-check";
import { describe, expect, it } from "vitest";

import { LatencyMeter } from "@/features/play/stream/latency";

describe("the latency of a game", () => {
  it("is the time from a press to the first frame drawn with it", () => {
    const meter = new LatencyMeter();
    meter.press(1, 1000);
    expect(meter.show(1, 0, 1010)).toBeNull();
    expect(meter.show(2, 1, 1034)).toBe(34);
    expect(meter.show(3, 1, 1050)).toBeNull();
  });

  it("is that of the earliest of the presses that a frame is the first to show", () => {
    const meter = new LatencyMeter();
    meter.press(1, 1000);
    meter.press(2, 1008);
    meter.press(3, 1030);
    expect(meter.show(1, 2, 1040)).toBe(40);
    expect(meter.show(2, 3, 1052)).toBe(22);
    expect(meter.summary()).toMatchObject({ presses: 2, p50Ms: 22, p95Ms: 40 });
  });

  it("leaves out what waited when the game stood still", () => {
    const meter = new LatencyMeter();
    meter.press(1, 1000);
    meter.show(5, 0, 1010);
    meter.forget();
    expect(meter.show(9, 1, 9000)).toBeNull();
    expect(meter.summary()).toMatchObject({ presses: 0, p50Ms: null, dropped: 0 });
  });

  it("counts each frame after the first as drawn or dropped", () => {
    fc.assert(
      fc.property(fc.uniqueArray(fc.integer({ min: 0, max: 1200 }), { minLength: 1 }), (some) => {
        const frames = some.sort((a, b) => a - b);
        const meter = new LatencyMeter();
        frames.forEach((frame) => meter.show(frame, 0, frame));
        const { drawn, dropped } = meter.summary();
        expect(drawn).toBe(frames.length - 1);
        expect(drawn + dropped).toBe((frames.at(-1) ?? 0) - (frames[0] ?? 0));
      }),
    );
  });
});
