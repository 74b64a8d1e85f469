import fc from "fast-check";
import { describe, expect, it } from "vitest";

import type { GameOpinion } from "@/api/types";
import {
  answer,
  asking,
  begin,
  openAnswers,
  putBelow,
  questionOf,
  remaining,
  skip,
  skippedIn,
  type Session,
  type Situation,
  withoutLast,
} from "@/features/ranking/comparing/session";
import { place, type Tiers } from "@/features/ranking/order/order";

import { recording } from "../../../support/data";
import { tiers } from "../../../support/tiers";

const QUEUE = [101, 102, 103];

function situationOf(order: Tiers, more: Partial<Situation> = {}): Situation {
  const ids = [...order.flat(), ...QUEUE];
  return {
    tiers: order,
    recordings: new Map(ids.map((id) => [id, recording({ id })])),
    opinions: new Map(),
    ...more,
  };
}

const acts = {
  better: (session: Session, now: Situation) => answer(session, now, "better"),
  equal: (session: Session, now: Situation) => answer(session, now, "equal"),
  worse: (session: Session, now: Situation) => answer(session, now, "worse"),
  skip,
  below: (session: Session, now: Situation) => putBelow(session, now, "this"),
  all: (session: Session, now: Situation) => putBelow(session, now, "all"),
};
type Act = keyof typeof acts;
const names = Object.keys(acts) as Act[];

/** Does something and returns session and situation after it. */
function after(act: Act, session: Session, now: Situation): [Session, Situation] {
  const next = acts[act](session, now);
  return [next.session, { ...now, tiers: next.tiers }];
}

describe("placing several recordings", () => {
  it("asks about one after another, and numbers them", () => {
    let now = situationOf([[1], [2], [3]]);
    let session = begin(QUEUE, now);
    expect(questionOf(session, now)).toEqual({
      id: 101,
      opponent: 2,
      tier: 1,
      number: 1,
      looks: 2,
    });
    [session, now] = after("better", session, now);
    expect(questionOf(session, now)).toMatchObject({ id: 101, opponent: 1, looks: 1 });
    [session, now] = after("worse", session, now);
    expect(now.tiers).toEqual([[1], [101], [2], [3]]);
    expect(questionOf(session, now)).toMatchObject({ id: 102, number: 2 });
    [session, now] = after("skip", session, now);
    [session, now] = after("equal", session, now);
    expect(now.tiers).toEqual([[1], [101], [2, 103], [3]]);
    expect(questionOf(session, now)).toBeNull();
    expect([...skippedIn(session)]).toEqual([102]);
  });

  it("puts one, or all that are left, below the worst", () => {
    let now = situationOf([[1], [2]]);
    let session = begin(QUEUE, now);
    [session, now] = after("below", session, now);
    expect(now.tiers).toEqual([[1], [2], [101]]);
    [session, now] = after("all", session, now);
    expect(now.tiers).toEqual([[1], [2], [101], [102, 103]]);
    expect(remaining(session, now)).toEqual([]);
  });

  it("restores question and order exactly when all is taken back", () => {
    fc.assert(
      fc.property(tiers, fc.array(fc.constantFrom(...names), { maxLength: 20 }), (order, done) => {
        let now = situationOf(order);
        let session = begin(QUEUE, now);
        const before: { question: unknown; order: Tiers }[] = [];
        for (const act of done) {
          if (remaining(session, now).length === 0) break;
          before.push({ question: questionOf(session, now), order: now.tiers });
          [session, now] = after(act, session, now);
        }
        for (const { question, order: tiersBefore } of before.reverse()) {
          const last = session.steps.at(-1);
          if (last?.order) {
            now = {
              ...now,
              tiers: last.ids.reduce<Tiers>(
                (all, id) => place(all, id, { kind: "tray" }),
                now.tiers,
              ),
            };
          }
          session = withoutLast(session);
          expect(now.tiers).toEqual(tiersBefore);
          expect(questionOf(session, now)).toEqual(question);
        }
      }),
    );
  });

  it("changes the order only where a recording gets its place", () => {
    fc.assert(
      fc.property(tiers, fc.array(fc.constantFrom(...names), { maxLength: 20 }), (order, done) => {
        let now = situationOf(order);
        let session = begin(QUEUE, now);
        for (const act of done) {
          const { tiers: orderBefore } = now;
          [session, now] = after(act, session, now);
          const placed = now.tiers.flat().filter((id) => !orderBefore.flat().includes(id));
          expect(placed.length > 0).toBe(now.tiers !== orderBefore && placed.length > 0);
          const others = placed.reduce<Tiers>(
            (all, id) => place(all, id, { kind: "tray" }),
            now.tiers,
          );
          expect(others).toEqual(orderBefore);
        }
      }),
    );
  });
});

describe("what it is compared with", () => {
  it("is a person's own recording of the tier if there is one", () => {
    const order = [[1, 2, 3, 4]];
    const of = (...given: readonly [number, Partial<ReturnType<typeof recording>>][]) => {
      const now = situationOf(order);
      const recordings = new Map(now.recordings);
      given.forEach(([id, change]) => recordings.set(id, recording({ id, ...change })));
      return questionOf(begin(QUEUE, { ...now, recordings }), { ...now, recordings })?.opponent;
    };
    const borrowed = { borrowed: true };
    const varied = { source: "varied" } as const;
    expect(of()).toBe(1);
    expect(of([1, borrowed], [2, varied])).toBe(3);
    expect(of([1, borrowed], [2, varied], [3, varied], [4, varied])).toBe(2);
    expect(of([1, borrowed], [2, borrowed], [3, borrowed], [4, borrowed])).toBe(1);
  });

  it("begins where the opinion of its turn expects it, whatever a later one says", () => {
    const order = Array.from({ length: 9 }, (_, index) => [index + 1]);
    const opinion = (share: number): GameOpinion => ({
      recording_id: 101,
      place: share,
      best_place: share - 0.05,
      worst_place: share + 0.05,
      tier: 1,
      best_tier: 1,
      worst_tier: 1,
      contradicted_by: [],
    });
    const now = situationOf(order, { opinions: new Map([[101, opinion(0.85)]]) });
    const session = begin(QUEUE, now);
    expect(questionOf(session, now)).toMatchObject({ tier: 7 });
    const later = { ...now, opinions: new Map([[101, opinion(0.1)]]) };
    expect(questionOf(session, later)).toMatchObject({ tier: 7 });
  });
});

describe("a session that was closed", () => {
  it("leaves its answers to the next one, if they led to no place", () => {
    let now = situationOf([[1], [2], [3]]);
    let session = begin(QUEUE, now);
    [session, now] = after("equal", session, now);
    [session, now] = after("worse", session, now);
    const open = openAnswers(session, now);
    expect(open).toEqual([{ id: 102, answer: { opponent: 2, verdict: "worse" } }]);
    expect(questionOf(begin(QUEUE, now, open), now)).toEqual(questionOf(session, now));
    expect(begin([103], now, open).steps).toEqual([]);
  });
});

describe("a change made elsewhere", () => {
  it("passes over what was ranked or went away there", () => {
    const now = situationOf([[1], [2]]);
    const session = begin(QUEUE, now);
    const recordings = new Map(now.recordings);
    recordings.delete(102);
    const elsewhere = { ...now, tiers: [[1], [101], [2]], recordings };
    expect(questionOf(session, elsewhere)).toMatchObject({ id: 103, number: 3 });
  });

  it("does not change what is asked, nor what an answer is about", () => {
    const now = situationOf([[1], [2], [3]]);
    const session = begin(QUEUE, now);
    expect(questionOf(session, now)).toMatchObject({ id: 101, opponent: 2, tier: 1 });
    const elsewhere = { ...now, tiers: [[2], [4], [3], [1]] };
    expect(asking(session, elsewhere)).toBe(session);
    expect(questionOf(session, elsewhere)).toMatchObject({ id: 101, opponent: 2, tier: 0 });
    expect(answer(session, elsewhere, "better").tiers[0]).toEqual([101]);
    const gone = { ...now, tiers: [[1], [3]] };
    expect(asking(session, gone).asked).toMatchObject({ id: 101, opponent: 3 });
  });

  it("has a recording asked about again that lost its place", () => {
    let now = situationOf([[1], [2]]);
    let session = begin(QUEUE, now);
    [session, now] = after("worse", session, now);
    expect(now.tiers).toEqual([[1], [2], [101]]);
    expect(questionOf(session, { ...now, tiers: [[1], [2]] })).toMatchObject({ id: 101 });
  });

  it("leaves nothing to ask if nothing is ranked any more", () => {
    const now = situationOf([[1], [2]]);
    const session = begin(QUEUE, now);
    expect(questionOf(session, { ...now, tiers: [] })).toBeNull();
    expect(remaining(session, { ...now, tiers: [] })).toEqual(QUEUE);
  });
});
