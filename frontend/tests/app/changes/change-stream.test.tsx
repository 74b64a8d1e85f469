import { QueryClient } from "@tanstack/react-query";
import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";

import { listenToChanges } from "@/app/changes/change-stream";
import { Invalidator, staleKeys } from "@/app/changes/invalidation";

class FakeEventSource extends EventTarget {
  static readonly CLOSED = 2;
  static readonly opened: FakeEventSource[] = [];
  readyState = 0;

  constructor() {
    super();
    FakeEventSource.opened.push(this);
  }

  close(): void {
    this.readyState = FakeEventSource.CLOSED;
  }

  change(topic: string, key: string): void {
    this.dispatchEvent(new MessageEvent("change", { data: JSON.stringify({ topic, key }) }));
  }
}

/** Locks as a browser keeps them: one holder at a time, the others wait in order. */
class FakeLocks {
  private tail: Promise<unknown> = Promise.resolve();
  private held = 0;

  async request(
    _name: string,
    options: { signal?: AbortSignal; ifAvailable?: boolean },
    work: (lock: object | null) => Promise<void> | undefined,
  ): Promise<void> {
    if (options.ifAvailable && this.held > 0) return work(null);
    this.held += 1;
    const turn = this.tail
      .then(() => (options.signal?.aborted ? undefined : work({})))
      .finally(() => (this.held -= 1));
    this.tail = turn;
    return turn;
  }
}

/** Channels of one name hear each other, but not themselves. */
class FakeChannel {
  static all: FakeChannel[] = [];
  onmessage: ((event: MessageEvent) => void) | null = null;

  constructor() {
    FakeChannel.all.push(this);
  }

  postMessage(data: unknown): void {
    for (const other of FakeChannel.all) {
      if (other !== this) other.onmessage?.(new MessageEvent("message", { data }));
    }
  }

  close(): void {
    FakeChannel.all = FakeChannel.all.filter((other) => other !== this);
  }
}

function tab() {
  const heard: string[] = [];
  const states: boolean[] = [];
  const stop = listenToChanges({
    onChange: ({ topic, key }) => heard.push(`${topic} ${key}`),
    onReconnect: () => heard.push("again"),
    onLive: (live) => states.push(live),
  });
  return { heard, states, stop };
}

const settled = () => vi.advanceTimersByTimeAsync(0);

beforeEach(() => {
  vi.useFakeTimers();
  FakeEventSource.opened.length = 0;
  FakeChannel.all = [];
  vi.stubGlobal("EventSource", FakeEventSource);
  vi.stubGlobal("BroadcastChannel", FakeChannel);
  vi.stubGlobal("navigator", { locks: new FakeLocks() });
});

afterEach(() => {
  vi.useRealTimers();
});

describe("the event stream", () => {
  it("is one for all tabs, and each hears every change once", async () => {
    const tabs = [tab(), tab(), tab()];
    await settled();
    expect(FakeEventSource.opened).toHaveLength(1);
    FakeEventSource.opened[0]?.change("run", "r1");
    for (const { heard } of tabs) expect(heard).toEqual(["run r1"]);
  });

  it("passes to the next tab when the one that has it is closed", async () => {
    const [first, second] = [tab(), tab()];
    await settled();
    first.stop();
    await settled();
    expect(FakeEventSource.opened[0]?.readyState).toBe(FakeEventSource.CLOSED);
    expect(FakeEventSource.opened).toHaveLength(2);
    FakeEventSource.opened[1]?.dispatchEvent(new Event("open"));
    FakeEventSource.opened[1]?.change("ranking", "3");
    // What changed in between was told to nobody, so that all is fetched again.
    expect(second.heard).toEqual(["again", "ranking 3"]);
    expect(first.heard).toEqual([]);
  });

  it("tells when it is back after a break", async () => {
    const { heard } = tab();
    await settled();
    const [source] = FakeEventSource.opened;
    source?.dispatchEvent(new Event("open"));
    expect(heard).toEqual([]);
    source?.dispatchEvent(new Event("error"));
    source?.dispatchEvent(new Event("open"));
    expect(heard).toEqual(["again"]);
  });

  it("is opened anew where the browser gave up", async () => {
    tab();
    await settled();
    const [source] = FakeEventSource.opened;
    source?.close();
    source?.dispatchEvent(new Event("error"));
    await vi.advanceTimersByTimeAsync(3000);
    expect(FakeEventSource.opened).toHaveLength(2);
  });

  it("is opened anew where it went silent, and every tab knows that it was", async () => {
    const tabs = [tab(), tab()];
    await settled();
    const [source] = FakeEventSource.opened;
    source?.dispatchEvent(new Event("open"));
    for (let i = 0; i < 6; i += 1) {
      await vi.advanceTimersByTimeAsync(5000);
      source?.dispatchEvent(new MessageEvent("ping"));
    }
    expect(FakeEventSource.opened).toHaveLength(1);
    for (const { states } of tabs) expect(states).not.toContain(false);
    await vi.advanceTimersByTimeAsync(11_000);
    expect(source?.readyState).toBe(FakeEventSource.CLOSED);
    expect(FakeEventSource.opened).toHaveLength(2);
    for (const { states } of tabs) expect(states.at(-1)).toBe(false);
    FakeEventSource.opened[1]?.dispatchEvent(new Event("open"));
    for (const { heard, states } of tabs) {
      expect(states.at(-1)).toBe(true);
      expect(heard).toEqual(["again"]);
    }
  });

  it("is tried again and again while nothing passes", async () => {
    const { states, stop } = tab();
    await settled();
    await vi.advanceTimersByTimeAsync(35_000);
    expect(FakeEventSource.opened.length).toBeGreaterThan(3);
    expect(states).not.toContain(true);
    stop();
    const before = FakeEventSource.opened.length;
    await vi.advanceTimersByTimeAsync(35_000);
    expect(FakeEventSource.opened).toHaveLength(before);
  });

  it.each([
    {},
    { locks: { request: () => Promise.reject(new DOMException("denied", "SecurityError")) } },
  ])("is one per tab where there are no locks", async (navigator) => {
    vi.stubGlobal("navigator", navigator);
    tab();
    tab();
    await settled();
    expect(FakeEventSource.opened).toHaveLength(2);
  });
});

describe("a change", () => {
  it("makes stale what shows the thing, and nothing else", () => {
    expect(staleKeys({ topic: "ranking", key: "3" })).toContainEqual(["ranking", 3]);
    expect(staleKeys({ topic: "ranking", key: "3" })).toContainEqual(["opinion", 3]);
    expect(staleKeys({ topic: "ranking", key: "3" })).toContainEqual(["understanding", 3]);
    expect(staleKeys({ topic: "run", key: "r1" })).toContainEqual(["metrics", "r1"]);
    expect(staleKeys({ topic: "unheard of", key: "1" })).toEqual([]);
  });

  it("that comes many times refetches once", async () => {
    const client = new QueryClient();
    const invalidate = vi.spyOn(client, "invalidateQueries").mockResolvedValue();
    const invalidator = new Invalidator(client);
    for (let i = 0; i < 50; i += 1) invalidator.add({ topic: "system", key: "w" });
    await vi.advanceTimersByTimeAsync(1000);
    expect(invalidate).toHaveBeenCalledTimes(1);
    expect(invalidate).toHaveBeenCalledWith({ queryKey: ["system"] });
  });
});
