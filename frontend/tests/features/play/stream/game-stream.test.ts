import { zlibSync } from "fflate";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";

import { type GameScreen, GameStream } from "@/features/play/stream/game-stream";
import { CLOSE } from "@/features/play/stream/text-messages";

const SCREEN_BYTES = 160 * 210;

/** The server's end of a WebSocket, controlled by the test. */
class FakeSocket extends EventTarget {
  static readonly OPEN = 1;
  static readonly opened: FakeSocket[] = [];

  readonly url: string;
  readyState = FakeSocket.OPEN;
  binaryType = "blob";
  readonly sent: (string | ArrayBuffer)[] = [];

  constructor(url: string) {
    super();
    this.url = url;
    FakeSocket.opened.push(this);
  }

  send(data: string | ArrayBuffer): void {
    this.sent.push(data);
  }

  close(code = 1000): void {
    if (this.readyState === 3) return;
    this.readyState = 3;
    this.dispatchEvent(Object.assign(new Event("close"), { code }));
  }

  tell(message: object): void {
    this.dispatchEvent(new MessageEvent("message", { data: JSON.stringify(message) }));
  }

  show(
    sequence: number,
    frame: number,
    payload: Uint8Array = zlibSync(new Uint8Array(SCREEN_BYTES)),
    inputSequence = 0,
  ) {
    const data = new Uint8Array(16 + payload.length);
    const view = new DataView(data.buffer);
    view.setUint8(0, 1);
    view.setUint8(1, 1);
    view.setUint8(2, 23 + 96);
    view.setUint8(3, 31);
    view.setUint32(4, sequence, true);
    view.setUint32(8, frame, true);
    view.setUint32(12, inputSequence, true);
    data.set(payload, 16);
    this.dispatchEvent(new MessageEvent("message", { data: data.buffer }));
  }

  get binarySent(): number[][] {
    return this.sent
      .filter((one) => typeof one !== "string")
      .map((one) => [...new Uint8Array(one)]);
  }

  get commandsSent(): string[] {
    return this.sent
      .filter((one) => typeof one === "string")
      .map((one) => (JSON.parse(one) as { type: string }).type);
  }
}

const HELLO = {
  type: "hello",
  width: 160,
  height: 210,
  palette: [],
  max_frames: 1200,
  frame: 0,
  resumed: false,
  hits: [],
  speed_percent: 100,
  overlay: {
    painter: "alien-formation",
    geometry: { width: 8, height: 10, column_px: 16, row_px: 18 },
  },
};
const ENDED = {
  type: "ended",
  reason: "hit",
  frame: 400,
  hits: [],
  targets: 0,
  strays: 0,
  order_errors: null,
  recording_id: 7,
  verification: "verified",
  verification_note: "",
};

function begin() {
  const screen = { setFormat: vi.fn(), show: vi.fn() } satisfies GameScreen;
  const stream = new GameStream("ws://test/stream", screen);
  stream.connect();
  return { screen, stream, socket: newest() };
}

function newest(): FakeSocket {
  const socket = FakeSocket.opened.at(-1);
  if (!socket) throw new Error("No connection was opened.");
  return socket;
}

beforeEach(() => {
  vi.useFakeTimers();
  vi.stubGlobal("WebSocket", FakeSocket);
  vi.stubGlobal("document", { hidden: false });
  FakeSocket.opened.length = 0;
});

afterEach(() => {
  vi.useRealTimers();
  vi.unstubAllGlobals();
});

describe("a game's stream", () => {
  it("says that it is ready, counts down, and plays", () => {
    const { stream, socket } = begin();
    expect(stream.snapshot().phase).toBe("connecting");
    socket.tell(HELLO);
    expect(socket.commandsSent).toEqual(["ready"]);
    socket.tell({ type: "countdown", seconds: 3 });
    expect(stream.snapshot()).toMatchObject({ phase: "countdown", seconds: 3 });
    socket.tell({ type: "countdown", seconds: 0 });
    expect(stream.snapshot().phase).toBe("playing");
  });

  it("draws each frame and then acknowledges it", () => {
    const { screen, socket } = begin();
    socket.tell(HELLO);
    socket.show(1, 0);
    socket.show(2, 1);
    expect(screen.show).toHaveBeenCalledTimes(2);
    const seen = { frame: 1, marks: Uint8Array.of(23 + 96, 31), hasCounted: false };
    const lastSeen = expect.objectContaining(seen) as unknown;
    expect(screen.show).toHaveBeenLastCalledWith(expect.any(Uint8Array), lastSeen, 1200);
    expect(socket.binarySent).toEqual([
      [2, 0, 0, 0, 1, 0, 0, 0],
      [2, 0, 0, 0, 2, 0, 0, 0],
    ]);
  });

  it("knows what may be drawn over the screens once the server has sent it", () => {
    const { stream, socket } = begin();
    expect(stream.overlay).toBeNull();
    socket.tell(HELLO);
    expect(stream.overlay).toEqual(HELLO.overlay);
  });

  it("sends the held keys when they change, numbered", () => {
    const { stream, socket } = begin();
    socket.tell(HELLO);
    stream.hold(5);
    stream.hold(5);
    stream.hold(0);
    expect(socket.binarySent).toEqual([
      [1, 5, 0, 0, 1, 0, 0, 0],
      [1, 0, 0, 0, 2, 0, 0, 0],
    ]);
  });

  it("says with the acknowledgement how long a key took to be drawn", () => {
    const { stream, socket } = begin();
    socket.tell(HELLO);
    socket.tell({ type: "countdown", seconds: 0 });
    const payload = zlibSync(new Uint8Array(SCREEN_BYTES));
    socket.show(1, 1);
    stream.hold(4);
    vi.advanceTimersByTime(30);
    socket.show(2, 2, payload, 0);
    vi.advanceTimersByTime(12);
    socket.show(3, 3, payload, 1);
    socket.show(4, 6, payload, 1);
    expect(socket.binarySent.slice(1)).toEqual([
      [1, 4, 0, 0, 1, 0, 0, 0],
      [2, 0, 0, 0, 2, 0, 0, 0],
      [2, 0, 420 % 256, 1, 3, 0, 0, 0],
      [2, 0, 0, 0, 4, 0, 0, 0],
    ]);
    expect(stream.latencySummary()).toEqual({
      presses: 1,
      p50Ms: 42,
      p95Ms: 42,
      drawn: 3,
      dropped: 2,
    });
  });

  it("times no key that went down while the game stood still", () => {
    const { stream, socket } = begin();
    socket.tell(HELLO);
    socket.tell({ type: "paused", why: "You paused the game." });
    stream.hold(4);
    socket.tell({ type: "countdown", seconds: 0 });
    socket.show(1, 1, undefined, 1);
    expect(stream.latencySummary().presses).toBe(0);
  });

  it("times no key in slow motion", () => {
    const { stream, socket } = begin();
    socket.tell(HELLO);
    socket.tell({ type: "countdown", seconds: 0 });
    stream.setSpeed(50);
    stream.hold(4);
    socket.show(1, 1, undefined, 1);
    expect(stream.latencySummary().presses).toBe(0);
  });

  it("plays a new game at the speed of the one before, and another one at its own", () => {
    const screen = { setFormat: vi.fn(), show: vi.fn() } satisfies GameScreen;
    const stream = new GameStream("ws://test/stream", screen, 50);
    stream.connect();
    newest().tell(HELLO);
    expect(newest().commandsSent).toEqual(["speed", "ready"]);
    expect(newest().sent[0]).toBe('{"type":"speed","percent":50}');
    newest().close(1006);
    vi.advanceTimersByTime(300);
    newest().tell({ ...HELLO, frame: 40, resumed: true, speed_percent: 75 });
    expect(newest().commandsSent).toEqual(["ready"]);
    expect(stream.snapshot().speed).toBe(75);
  });

  it("plays single frames of a paused game only", () => {
    const { stream, socket } = begin();
    socket.tell(HELLO);
    socket.tell({ type: "countdown", seconds: 0 });
    stream.step();
    expect(socket.commandsSent).toEqual(["ready"]);
    socket.tell({ type: "paused", why: "You paused the game." });
    stream.step();
    stream.step();
    expect(socket.commandsSent).toEqual(["ready", "step", "step"]);
    expect(stream.snapshot().phase).toBe("stepping");
    socket.tell({ type: "countdown", seconds: 3 });
    expect(stream.snapshot().phase).toBe("countdown");
  });

  it("rewinds until released, undoing hits", () => {
    const { screen, stream, socket } = begin();
    const hit = { row: 0, column: 2, frame: 100, on_target: true };
    socket.tell({ ...HELLO, frame: 130, hits: [hit, { ...hit, row: 1, frame: 120 }] });
    socket.tell({ type: "countdown", seconds: 0 });
    stream.release();
    stream.rewind();
    stream.rewind();
    expect(stream.snapshot().phase).toBe("rewinding");
    socket.show(1, 130);
    socket.show(2, 128);
    expect(screen.show).toHaveBeenLastCalledWith(
      expect.any(Uint8Array),
      expect.objectContaining({ frame: 128 }),
      1200,
    );
    stream.release();
    expect(socket.commandsSent).toEqual(["ready", "rewind", "release"]);
    socket.tell({ type: "rewound", frame: 110, hits: [hit], recording_id: 6 });
    expect(stream.snapshot().hits).toEqual([hit]);
    socket.tell({ type: "countdown", seconds: 3 });
    expect(stream.snapshot().phase).toBe("countdown");
    expect(stream.latencySummary()).toMatchObject({ drawn: 0, dropped: 0 });
  });

  it("collects hits and ends with all of them", () => {
    const { stream, socket } = begin();
    socket.tell(HELLO);
    const hit = { row: 0, column: 2, frame: 100, on_target: true };
    socket.tell({ type: "hit", ...hit, targets: 1, strays: 0 });
    expect(stream.snapshot().hits).toMatchObject([hit]);
    socket.tell({ ...ENDED, hits: [hit, { ...hit, row: 1 }] });
    socket.close(CLOSE.gameOver);
    expect(stream.snapshot()).toMatchObject({ phase: "ended", ended: { recording_id: 7 } });
    expect(stream.snapshot().hits).toHaveLength(2);
    vi.advanceTimersByTime(60_000);
    expect(FakeSocket.opened).toHaveLength(1);
  });

  it("reconnects with the keys still held", () => {
    const { stream, socket } = begin();
    socket.tell(HELLO);
    stream.hold(4);
    socket.close(1006);
    expect(stream.snapshot().phase).toBe("lost");
    vi.advanceTimersByTime(300);
    const again = newest();
    expect(again).not.toBe(socket);
    again.tell({
      ...HELLO,
      resumed: true,
      hits: [{ row: 0, column: 0, frame: 9, on_target: true }],
    });
    expect(again.commandsSent).toEqual(["ready"]);
    expect(again.binarySent).toEqual([[1, 4, 0, 0, 2, 0, 0, 0]]);
    expect(stream.snapshot().hits).toHaveLength(1);
  });

  it("says when all places are taken, and tries again", () => {
    const { stream, socket } = begin();
    socket.close(CLOSE.tryAgainLater);
    expect(stream.snapshot().phase).toBe("full");
    vi.advanceTimersByTime(300);
    newest().tell({ ...HELLO, frame: 60, resumed: true });
    newest().tell({ type: "countdown", seconds: 3 });
    expect(stream.snapshot().phase).toBe("countdown");
  });

  it("waits longer after each failure, up to four seconds", () => {
    begin();
    const waits = [250, 500, 1000, 2000, 4000, 4000];
    for (const wait of waits) {
      newest().close(1006);
      const before = FakeSocket.opened.length;
      vi.advanceTimersByTime(wait - 1);
      expect(FakeSocket.opened).toHaveLength(before);
      vi.advanceTimersByTime(1);
      expect(FakeSocket.opened).toHaveLength(before + 1);
    }
  });

  it("is lost within three seconds of silence, and the game goes on over a new connection", () => {
    const { stream, socket } = begin();
    socket.tell(HELLO);
    socket.tell({ type: "countdown", seconds: 0 });
    for (let frame = 1; frame < 60; frame += 1) {
      vi.advanceTimersByTime(100);
      socket.show(frame, frame);
    }
    expect(stream.snapshot().phase).toBe("playing");
    vi.advanceTimersByTime(3000);
    expect(stream.snapshot().phase).toBe("lost");
    vi.advanceTimersByTime(250);
    expect(FakeSocket.opened).toHaveLength(2);
    // What a cable held back comes too late.
    socket.tell({ type: "countdown", seconds: 3 });
    expect(stream.snapshot().phase).toBe("lost");
    newest().tell({ ...HELLO, frame: 59, resumed: true });
    expect(newest().commandsSent).toEqual(["ready"]);
  });

  it("is not lost while the server says that it is alive", () => {
    const { stream, socket } = begin();
    socket.tell(HELLO);
    socket.tell({ type: "paused", why: "You paused the game." });
    for (let second = 0; second < 60; second += 1) {
      vi.advanceTimersByTime(1000);
      socket.tell({ type: "alive" });
    }
    expect(stream.snapshot().phase).toBe("paused");
    vi.advanceTimersByTime(3000);
    expect(stream.snapshot().phase).toBe("lost");
  });

  it("gives a connection up that is never answered, later each time", () => {
    begin();
    const opened = [5500, 10_500, 15_500, 20_500].map((limit) => {
      vi.advanceTimersByTime(limit);
      vi.advanceTimersByTime(4000);
      return FakeSocket.opened.length;
    });
    expect(opened).toEqual([2, 3, 4, 5]);
  });

  it("leaves a paused game paused when the connection is back", () => {
    const { stream, socket } = begin();
    socket.tell(HELLO);
    socket.tell({ type: "paused", why: "The disk is full." });
    socket.close(1006);
    vi.advanceTimersByTime(300);
    newest().tell({ ...HELLO, frame: 40, resumed: true });
    expect(newest().commandsSent).toEqual([]);
    expect(stream.snapshot()).toMatchObject({ phase: "paused", why: "The disk is full." });
    newest().tell({ type: "countdown", seconds: 3 });
    newest().close(1006);
    vi.advanceTimersByTime(300);
    newest().tell({ ...HELLO, frame: 40, resumed: true });
    expect(newest().commandsSent).toEqual(["ready"]);
  });

  it("does not begin in a tab that nobody sees", () => {
    vi.stubGlobal("document", { hidden: true });
    const { stream, socket } = begin();
    socket.tell(HELLO);
    expect(socket.commandsSent).toEqual([]);
    expect(stream.snapshot()).toMatchObject({ phase: "paused" });
  });

  it("pauses after the page or the machine was suspended", () => {
    const { stream, socket } = begin();
    socket.tell(HELLO);
    socket.tell({ type: "countdown", seconds: 0 });
    vi.setSystemTime(Date.now() + 60_000);
    vi.advanceTimersByTime(500);
    expect(socket.commandsSent).toEqual(["ready", "pause"]);
    socket.tell({ type: "paused", why: "You paused the game." });
    expect(stream.snapshot().why).toMatch(
      /^This page stood still for 60\ss, so the game is paused/,
    );
    vi.advanceTimersByTime(500);
    expect(socket.commandsSent).toHaveLength(2);
  });

  it("leaves the game to another tab, until it is taken back", () => {
    const { stream, socket } = begin();
    socket.tell(HELLO);
    socket.tell({ type: "taken_over" });
    socket.close(CLOSE.takenOver);
    expect(stream.snapshot().phase).toBe("elsewhere");
    vi.advanceTimersByTime(60_000);
    expect(FakeSocket.opened).toHaveLength(1);
    stream.connect();
    expect(FakeSocket.opened).toHaveLength(2);
  });

  it.each([
    [CLOSE.noSuchGame, "gone"],
    [CLOSE.gameOver, "gone"],
    [CLOSE.unauthorised, "refused"],
  ])("doesn't try again after %d", (code, phase) => {
    const { stream, socket } = begin();
    socket.close(code);
    expect(stream.snapshot().phase).toBe(phase);
    vi.advanceTimersByTime(60_000);
    expect(FakeSocket.opened).toHaveLength(1);
  });

  it("starts a new chain of frames when one can't be read", () => {
    const { stream, socket } = begin();
    socket.tell(HELLO);
    socket.show(1, 0, new Uint8Array([1, 2, 3]));
    expect(stream.snapshot().phase).toBe("lost");
    vi.advanceTimersByTime(300);
    expect(FakeSocket.opened).toHaveLength(2);
  });

  it("stays disconnected after leaving", () => {
    const { stream, socket } = begin();
    stream.leave();
    expect(socket.readyState).toBe(3);
    vi.advanceTimersByTime(60_000);
    expect(FakeSocket.opened).toHaveLength(1);
  });
});
