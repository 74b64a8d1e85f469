import { describe, expect, it } from "vitest";

import { Playback } from "@/lib/game/playback";

/** A clock that advances only when told to. */
class HandClock {
  time = 0;
  private callbacks = new Map<number, () => void>();
  private next = 1;

  now = () => this.time;

  request = (callback: () => void): number => {
    this.callbacks.set(this.next, callback);
    return this.next++;
  };

  cancel = (id: number) => {
    this.callbacks.delete(id);
  };

  get isIdle(): boolean {
    return this.callbacks.size === 0;
  }

  pass(ms: number): void {
    this.time += ms;
    const due = [...this.callbacks.values()];
    this.callbacks.clear();
    due.forEach((callback) => callback());
  }
}

function playing(last = 600, loop = false) {
  const clock = new HandClock();
  const playback = new Playback(last, 60, { loop, clock });
  playback.play();
  return { clock, playback };
}

describe("playing a recording", () => {
  it("shows the frame that the clock says, however seldom it is asked", () => {
    const { clock, playback } = playing();
    clock.pass(500);
    expect(playback.snapshot().frame).toBe(30);
    clock.pass(2500);
    expect(playback.snapshot().frame).toBe(180);
  });

  it("stops at the end, and restarts from the beginning", () => {
    const { clock, playback } = playing(60);
    clock.pass(5000);
    expect(playback.snapshot()).toMatchObject({ frame: 60, playing: false });
    expect(clock.isIdle).toBe(true);
    playback.play();
    expect(playback.snapshot()).toMatchObject({ frame: 0, playing: true });
  });

  it("loops if asked to", () => {
    const { clock, playback } = playing(60, true);
    clock.pass(5000);
    expect(playback.snapshot()).toMatchObject({ frame: 0, playing: true });
    clock.pass(500);
    expect(playback.snapshot().frame).toBe(30);
  });

  it("changes speed without a jump", () => {
    const { clock, playback } = playing();
    clock.pass(1000);
    playback.setSpeed(0.5);
    expect(playback.snapshot().frame).toBe(60);
    clock.pass(1000);
    expect(playback.snapshot().frame).toBe(90);
  });

  it("steps frame by frame and pauses", () => {
    const { clock, playback } = playing();
    clock.pass(1000);
    playback.step(-1);
    clock.pass(1000);
    expect(playback.snapshot()).toMatchObject({ frame: 59, playing: false });
    playback.step(-1000);
    expect(playback.snapshot().frame).toBe(0);
  });

  it("continues from where it was sought", () => {
    const { clock, playback } = playing();
    playback.seek(300);
    clock.pass(100);
    expect(playback.snapshot().frame).toBe(306);
    playback.pause();
    expect(clock.isIdle).toBe(true);
  });
});
