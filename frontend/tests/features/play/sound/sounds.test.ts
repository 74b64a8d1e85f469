import { describe, expect, it, vi } from "vitest";

import { SOUNDS, Sounds } from "@/features/play/sound/sounds";

function fakeContext(state: AudioContextState) {
  const param = () => ({ setValueAtTime: vi.fn(), exponentialRampToValueAtTime: vi.fn() });
  const oscillators: { start: ReturnType<typeof vi.fn>; stop: ReturnType<typeof vi.fn> }[] = [];
  const context = {
    state,
    currentTime: 10,
    destination: {},
    resume: vi.fn(() => Promise.resolve()),
    close: vi.fn(() => Promise.resolve()),
    createGain: () => ({ gain: param(), connect: vi.fn() }),
    createOscillator: () => {
      const gain = { connect: vi.fn() };
      const oscillator = {
        type: "sine",
        frequency: param(),
        connect: () => gain,
        start: vi.fn(),
        stop: vi.fn(),
      };
      oscillators.push(oscillator);
      return oscillator;
    },
  };
  return { context, oscillators, sounds: new Sounds(context as unknown as AudioContext) };
}

describe("sounds", () => {
  it("play their tones one after the other, and end", () => {
    const { oscillators, sounds } = fakeContext("running");
    sounds.play("target");
    expect(oscillators.map(({ start }) => start.mock.calls[0]?.[0] as number)).toEqual(
      SOUNDS.target.map(({ delayS }) => 10 + delayS),
    );
    for (const [n, { stop }] of oscillators.entries()) {
      const tone = SOUNDS.target[n];
      expect(stop).toHaveBeenCalledWith(10 + (tone?.delayS ?? NaN) + (tone?.durationS ?? NaN));
    }
  });

  it("are left out while the browser does not let them be heard", () => {
    const { context, oscillators, sounds } = fakeContext("suspended");
    sounds.play("shot");
    expect(oscillators).toEqual([]);
    expect(context.resume).toHaveBeenCalledOnce();
    sounds.close();
    expect(context.close).toHaveBeenCalledOnce();
  });
});
