import { describe, expect, it, vi } from "vitest";

import type { Tiers } from "@/features/ranking/order/order";
import { RankingSaver, type Revision, type RankingBackend } from "@/features/ranking/order/saver";

class Conflict extends Error {
  readonly current: Revision;

  constructor(current: Revision) {
    super("Somebody saved first.");
    this.current = current;
  }
}

function revision(number: number, tiers: Tiers): Revision {
  return { revision: number, tiers, can_undo: true, can_redo: false };
}

/** A server with one ranking; answers wait until they are let out. */
class Server {
  standing = revision(1, [[1], [2]]);
  readonly asked: { base: number; tiers: Tiers }[] = [];
  failure: Error | null = null;
  private readonly waiting: (() => void)[] = [];

  readonly backend: RankingBackend = {
    save: (base, tiers) => {
      this.asked.push({ base, tiers });
      return this.answer(base, () => tiers);
    },
    step: (base) => this.answer(base, () => [[2], [1]]),
    conflictOf: (error) => (error instanceof Conflict ? error.current : null),
  };

  private answer(base: number, next: () => Tiers): Promise<Revision> {
    return new Promise((resolve, reject) => {
      this.waiting.push(() => {
        if (this.failure) reject(this.failure);
        else if (base !== this.standing.revision) reject(new Conflict(this.standing));
        else {
          this.standing = revision(base + 1, next());
          resolve(this.standing);
        }
      });
    });
  }

  async letOut(): Promise<void> {
    await vi.waitFor(() => expect(this.waiting.length).toBeGreaterThan(0));
    this.waiting.shift()?.();
    await new Promise((resolve) => setTimeout(resolve));
  }
}

function begin() {
  const server = new Server();
  return { server, saver: new RankingSaver(server.standing, server.backend) };
}

describe("an order that is held for a drag", () => {
  it("gives way when the drag is over, to the newest one", () => {
    const { saver } = begin();
    saver.hold();
    saver.receive(revision(2, [[2], [1]]));
    saver.receive(revision(3, [[2, 1]]));
    saver.receive(revision(2, [[2], [1]]));
    expect(saver.snapshot()).toMatchObject({ tiers: [[1], [2]], waiting: true, nReplaced: 0 });
    saver.release();
    expect(saver.snapshot()).toMatchObject({ tiers: [[2, 1]], waiting: false, nReplaced: 1 });
    expect(saver.snapshot().saved.revision).toBe(3);
  });

  it("is saved on the revision that was seen when the drag began", async () => {
    const { saver, server } = begin();
    saver.hold();
    server.standing = revision(2, [[2], [1]]);
    saver.receive(server.standing);
    saver.change([[1, 2]]);
    saver.release();
    await server.letOut();
    expect(server.asked).toEqual([{ base: 1, tiers: [[1, 2]] }]);
    expect(saver.snapshot()).toMatchObject({ tiers: [[1, 2]], conflict: server.standing });
  });

  it("is not changed by an undo that was on its way", async () => {
    const { saver, server } = begin();
    void saver.step("undo");
    saver.hold();
    await server.letOut();
    expect(saver.snapshot()).toMatchObject({ tiers: [[1], [2]], waiting: true });
    saver.release();
    expect(saver.snapshot().tiers).toEqual([[2], [1]]);
  });

  it("takes part in a conflict that arises during the drag", async () => {
    const { saver, server } = begin();
    saver.change([[2], [1]]);
    saver.hold();
    server.standing = revision(2, [[1, 2]]);
    await server.letOut();
    saver.change([[1]]);
    saver.release();
    saver.settle("mine");
    await server.letOut();
    expect(server.standing.tiers).toEqual([[1]]);
  });

  it("tells what is received while nothing is dragged", () => {
    const { saver } = begin();
    saver.receive(revision(1, [[1], [2]]));
    expect(saver.snapshot().nReplaced).toBe(0);
    saver.receive(revision(2, [[2], [1]]));
    expect(saver.snapshot().nReplaced).toBe(1);
  });
});

describe("saving an order as it is changed", () => {
  it("shows it at once and saves it on the revision that it was made from", async () => {
    const { server, saver } = begin();
    saver.change([[2], [1]]);
    expect(saver.snapshot()).toMatchObject({ tiers: [[2], [1]], saving: true });
    await server.letOut();
    expect(server.asked).toEqual([{ base: 1, tiers: [[2], [1]] }]);
    expect(saver.snapshot()).toMatchObject({ saving: false, saved: { revision: 2 } });
  });

  it("saves each thing that is done meanwhile afterwards, so that each can be undone", async () => {
    const { server, saver } = begin();
    saver.change([[2], [1]]);
    saver.change([[1, 2]]);
    saver.change([[2]]);
    for (let n = 0; n < 3; n += 1) await server.letOut();
    expect(server.asked).toEqual([
      { base: 1, tiers: [[2], [1]] },
      { base: 2, tiers: [[1, 2]] },
      { base: 3, tiers: [[2]] },
    ]);
    expect(saver.snapshot()).toMatchObject({ tiers: [[2]], saving: false, saved: { revision: 4 } });
  });

  it("sends nothing for an order that is the same", () => {
    const { server, saver } = begin();
    saver.change([[1], [2]]);
    expect(server.asked).toEqual([]);
  });

  it("keeps what could not be saved, and sends it again when told", async () => {
    const { server, saver } = begin();
    server.failure = new Error("The disk is full.");
    saver.change([[2], [1]]);
    await server.letOut();
    expect(saver.snapshot()).toMatchObject({ tiers: [[2], [1]], error: server.failure });
    server.failure = null;
    saver.retry();
    await server.letOut();
    expect(saver.snapshot()).toMatchObject({ error: null, saved: { tiers: [[2], [1]] } });
  });

  it("sends what is shown after a refusal, not what was refused before it", async () => {
    const { server, saver } = begin();
    server.failure = new Error("Recording 1 was deleted.");
    saver.change([[2], [1]]);
    saver.change([[2]]);
    await server.letOut();
    server.failure = null;
    saver.retry();
    await server.letOut();
    expect(server.asked.map(({ tiers }) => tiers)).toEqual([[[2], [1]], [[2]]]);
    expect(saver.snapshot()).toMatchObject({ error: null, saved: { revision: 2 } });
  });
});

describe("after a refusal", () => {
  it("sends the next order instead", async () => {
    const { server, saver } = begin();
    server.failure = new Error("Recording 1 was deleted.");
    saver.change([[2], [1]]);
    await server.letOut();
    server.failure = null;
    saver.change([[2]]);
    await server.letOut();
    expect(server.asked.map(({ tiers }) => tiers)).toEqual([[[2], [1]], [[2]]]);
    expect(saver.snapshot()).toMatchObject({ error: null, saving: false, saved: { revision: 2 } });
  });
});

describe("a save on an old revision", () => {
  async function conflict() {
    const { server, saver } = begin();
    server.standing = revision(5, [[1, 2]]);
    saver.change([[2], [1]]);
    await server.letOut();
    return { server, saver };
  }

  it("shows both orders and changes nothing until one is chosen", async () => {
    const { server, saver } = await conflict();
    expect(saver.snapshot()).toMatchObject({ tiers: [[2], [1]], conflict: { revision: 5 } });
    saver.change([[1]]);
    saver.receive(revision(6, [[2]]));
    expect(saver.snapshot().tiers).toEqual([[2], [1]]);
    expect(server.asked).toHaveLength(1);
  });

  it("takes theirs", async () => {
    const { server, saver } = await conflict();
    saver.settle("theirs");
    expect(saver.snapshot()).toMatchObject({ tiers: [[1, 2]], conflict: null });
    expect(server.asked).toHaveLength(1);
  });

  it("or saves mine on top of theirs", async () => {
    const { server, saver } = await conflict();
    saver.settle("mine");
    await server.letOut();
    expect(server.asked.at(-1)).toEqual({ base: 5, tiers: [[2], [1]] });
    expect(saver.snapshot()).toMatchObject({ conflict: null, saved: { revision: 6 } });
  });

  it("is none if both did the same", async () => {
    const { server, saver } = begin();
    server.standing = revision(5, [[2], [1]]);
    saver.change([[2], [1]]);
    await server.letOut();
    expect(saver.snapshot()).toMatchObject({ conflict: null, saved: { revision: 5 } });
  });
});

describe("a ranking received from the server", () => {
  it("is shown when no save is pending", () => {
    const { saver } = begin();
    saver.receive(revision(2, [[2, 1]]));
    expect(saver.snapshot().tiers).toEqual([[2, 1]]);
    saver.receive(revision(1, [[1], [2]]));
    expect(saver.snapshot().saved.revision).toBe(2);
  });

  it("is ignored while a save is pending", async () => {
    const { server, saver } = begin();
    saver.change([[2], [1]]);
    saver.receive(revision(2, [[1, 2]]));
    expect(saver.snapshot().tiers).toEqual([[2], [1]]);
    await server.letOut();
  });
});

describe("undo", () => {
  it("waits for pending saves, then shows the restored order", async () => {
    const { server, saver } = begin();
    saver.change([[1, 2]]);
    const undone = saver.step("undo");
    await server.letOut();
    await server.letOut();
    expect(await undone).toEqual({ from: [[1, 2]], to: [[2], [1]] });
    expect(saver.snapshot()).toMatchObject({ tiers: [[2], [1]], saved: { revision: 3 } });
  });

  it("asks for nothing where there is nothing to undo or redo", async () => {
    const server = new Server();
    const standing = { ...server.standing, can_undo: false };
    const saver = new RankingSaver(standing, server.backend);
    expect(await saver.step("undo")).toBeNull();
    expect(await saver.step("redo")).toBeNull();
    expect(saver.snapshot()).toMatchObject({ saving: false, error: null, tiers: standing.tiers });
  });

  it("of an outdated order shows the current one", async () => {
    const { server, saver } = begin();
    server.standing = revision(7, [[1, 2]]);
    const undone = saver.step("undo");
    await server.letOut();
    expect(await undone).toBeNull();
    expect(saver.snapshot()).toMatchObject({ tiers: [[1, 2]], conflict: null, saving: false });
  });
});
