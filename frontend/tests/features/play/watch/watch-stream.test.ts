import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";

import { CLOSE } from "@/features/play/stream/text-messages";
import { type LaneScreen, WatchStream } from "@/features/play/watch/watch-stream";

import { WATCH_HELLO, WatchSocket } from "../../../support/watch-socket";

const ENDED = {
  type: "ended",
  lane: 1,
  reason: "hit",
  frame: 400,
  hits: [{ row: 0, column: 0, frame: 99, on_target: true }],
  targets: 1,
  strays: 0,
  order_errors: null,
};

function screen() {
  return {
    setFormat: vi.fn<LaneScreen["setFormat"]>(),
    show: vi.fn<LaneScreen["show"]>(),
    decide: vi.fn<LaneScreen["decide"]>(),
    reward: vi.fn<LaneScreen["reward"]>(),
    attend: vi.fn<LaneScreen["attend"]>(),
  };
}

function begin(nLanes = 2, speed?: number) {
  const screens = Array.from({ length: nLanes }, screen);
  const stream = new WatchStream("ws://test/watch", screens, speed);
  stream.connect();
  const socket = WatchSocket.newest;
  socket.tell(WATCH_HELLO);
  return { screens, stream, socket };
}

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("WebSocket", WatchSocket);
  vi.stubGlobal("document", { hidden: false });
  WatchSocket.opened.length = 0;
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

describe("the stream of a page that watches", () => {
  it("plays at once, and keeps its speed over a restart", () => {
    const { stream, socket } = begin(1, 50);
    expect(stream.snapshot().openingFrames).toBe(96);
    expect(socket.commands).toEqual([{ type: "speed", percent: 50 }, { type: "play" }]);
  });

  it("is lost within three seconds of silence, and says nothing that comes after", () => {
    const { stream, socket } = begin(1);
    socket.tell({ type: "playing" });
    for (let second = 0; second < 30; second += 1) {
      vi.advanceTimersByTime(1000);
      socket.tell({ type: "alive" });
    }
    expect(stream.snapshot().phase).toBe("playing");
    vi.advanceTimersByTime(3000);
    expect(stream.snapshot().phase).toBe("lost");
    socket.tell({ type: "playing" });
    expect(stream.snapshot().phase).toBe("lost");
  });

  it("plays nothing where nobody sees it", () => {
    vi.stubGlobal("document", { hidden: true });
    const { stream, socket } = begin(1);
    expect(socket.commands).toEqual([]);
    expect(stream.snapshot().phase).toBe("paused");
  });

  it("pauses after the machine was suspended", () => {
    const { socket } = begin(1);
    socket.tell({ type: "playing" });
    vi.setSystemTime(Date.now() + 60_000);
    vi.advanceTimersByTime(500);
    expect(socket.commands).toEqual([{ type: "play" }, { type: "pause" }]);
  });

  it("shows each lane its own frames, and acknowledges them by lane", () => {
    const { screens, socket } = begin();
    socket.show(0, 1, 96, 3);
    socket.show(1, 1, 96, 5);
    socket.show(1, 2, 97, 7);
    const [first, second] = screens;
    expect(first?.show).toHaveBeenCalledTimes(1);
    expect(second?.show).toHaveBeenCalledTimes(2);
    expect(second?.show.mock.lastCall?.[0][0]).toBe(7);
    expect(socket.acks).toEqual([
      [0, 2, 0, 0, 0, 1, 0, 0, 0],
      [1, 2, 0, 0, 0, 1, 0, 0, 0],
      [1, 2, 0, 0, 0, 2, 0, 0, 0],
    ]);
  });

  it("passes decisions and rewards to their lane", () => {
    const { screens, socket } = begin();
    const decision = { type: "decision", lane: 1, frame: 96, action: 2, probabilities: [] };
    socket.tell(decision);
    socket.tell({ type: "reward", lane: 0, frame: 96, level: 0.25, deviation: null });
    expect(screens[1]?.decide).toHaveBeenCalledWith(decision);
    expect(screens[0]?.reward).toHaveBeenCalledWith(0.25, null);
    expect(screens[0]?.decide).not.toHaveBeenCalled();
  });

  it("asks for attention maps until nothing is to be shown, also of games that begin later", () => {
    const { screens, stream, socket } = begin();
    socket.tell({ type: "playing" });
    const map = { type: "attention", lane: 1, frame: 96, most: 0.5, action: null, shares: "" };
    stream.showAttention("reward");
    stream.showAttention("reward");
    socket.tell(map);
    stream.showAttention(null);
    socket.tell(map);
    expect(socket.commands.slice(1)).toEqual([
      { type: "attention", network: "reward" },
      { type: "attention", network: null },
    ]);
    expect(screens[1]?.attend).toHaveBeenCalledExactlyOnceWith(map);

    const next = new WatchStream("ws://test/watch", screens);
    next.connect();
    next.showAttention("policy");
    expect(WatchSocket.newest.commands).toEqual([]);
    WatchSocket.newest.tell(WATCH_HELLO);
    expect(WatchSocket.newest.commands).toEqual([
      { type: "attention", network: "policy" },
      { type: "play" },
    ]);
  });

  it("keeps the hits of each lane, and takes over only games that go on", () => {
    const { stream, socket } = begin();
    socket.tell({ type: "hit", lane: 0, row: 1, column: 2, frame: 120, on_target: false });
    socket.tell(ENDED);
    const [first, second] = stream.snapshot().lanes;
    expect(first?.hits).toHaveLength(1);
    expect(second?.ended?.reason).toBe("hit");
    stream.takeOver(1);
    stream.takeOver(0);
    expect(socket.commands.at(-1)).toEqual({ type: "take_over", lane: 0 });
    expect(socket.commands).toHaveLength(2);
  });

  it("toggles between playing and paused", () => {
    const { stream, socket } = begin();
    socket.tell({ type: "playing" });
    stream.toggle();
    socket.tell({ type: "paused", why: "" });
    stream.toggle();
    expect(socket.commands.slice(1)).toEqual([{ type: "pause" }, { type: "play" }]);
    socket.tell({ type: "waiting" });
    expect(stream.snapshot().phase).toBe("waiting");
  });

  it.each([
    [CLOSE.gameOver, "closed"],
    [1006, "lost"],
  ])("says why it closed: %i", (code, phase) => {
    const { stream, socket } = begin();
    socket.close(code);
    expect(stream.snapshot().phase).toBe(phase);
  });

  it("keeps the reason of a refusal, and the game that was taken over", () => {
    const refused = begin();
    refused.socket.tell({ type: "refused", why: "This training has no clone yet." });
    refused.socket.close(CLOSE.noSuchGame);
    expect(refused.stream.snapshot()).toMatchObject({
      phase: "refused",
      why: "This training has no clone yet.",
    });
    const taken = begin();
    taken.socket.tell({ type: "taken", lane: 0, game_id: "g", behaviour_id: 1 });
    taken.socket.close(CLOSE.gameOver);
    expect(taken.stream.snapshot()).toMatchObject({ phase: "taken", taken: { game_id: "g" } });
  });

  it("closes on a frame that it can't read", () => {
    const { stream, socket } = begin(1);
    socket.show(1, 1, 96);
    expect(stream.snapshot().phase).toBe("lost");
  });
});
