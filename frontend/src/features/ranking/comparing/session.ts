/**
 * Places several unranked recordings, one after another. Pure functions: a session is what was
 * chosen and done so far, and what to ask follows from it and from the order as it stands, which may
 * change elsewhere.
 */
import type { GameOpinion, LibraryEntry } from "@/api/types";
import { place, placeAll, tierOf, type Tiers } from "@/features/ranking/order/order";

import {
  type Answer,
  type Expectation,
  expectationOf,
  looksLeft,
  nextTier,
  placeAfter,
  type Verdict,
} from "./search";

interface Step {
  /** The recordings that it was about. */
  readonly ids: readonly number[];
  /** The answer; null if they were skipped or put below the worst. */
  readonly answer: Answer | null;
  /** The order with them in their place; null if they have none yet. */
  readonly order: Tiers | null;
}

export interface Session {
  /** The recordings to place, in their order. */
  readonly queue: readonly number[];
  readonly steps: readonly Step[];
  /** What opinions expected when a recording's turn came, so that a later one changes no question. */
  readonly opinions: ReadonlyMap<number, GameOpinion | null>;
  /** The recordings that are compared: another order alone does not change what is asked. */
  readonly asked: Pick<Question, "id" | "opponent"> | null;
}

export interface Question {
  readonly id: number;
  readonly opponent: number;
  /** The opponent's tier. */
  readonly tier: number;
  /** The number of this recording among all that are to be placed, from 1. */
  readonly number: number;
  /** About how many comparisons it takes from here. */
  readonly looks: number;
}

/** What the page shows at the moment. */
export interface Situation {
  readonly tiers: Tiers;
  readonly recordings: ReadonlyMap<number, LibraryEntry>;
  readonly opinions: ReadonlyMap<number, GameOpinion>;
}

/** Begins a session, with answers that an earlier one left without a place. */
export function begin(
  queue: readonly number[],
  situation: Situation,
  earlier: OpenAnswers = [],
): Session {
  const steps = earlier.flatMap(({ id, answer }) =>
    queue.includes(id) && tierOf(situation.tiers, id) < 0
      ? [{ ids: [id], answer, order: null }]
      : [],
  );
  return asking({ queue, steps, opinions: new Map(), asked: null }, situation);
}

/** Answers about recordings that have no place yet. */
export type OpenAnswers = readonly { readonly id: number; readonly answer: Answer }[];

/** Returns the answers that closing the session would lose. */
export function openAnswers({ steps }: Session, { tiers }: Situation): OpenAnswers {
  return steps.flatMap(({ ids: [id], answer }) =>
    id !== undefined && answer && tierOf(tiers, id) < 0 ? [{ id, answer }] : [],
  );
}

/** Returns the session with what is asked in it, which is the same session if it still can be. */
export function asking(session: Session, situation: Situation): Session {
  const noted = withOpinion(session, situation);
  const question = questionOf(noted, situation);
  const { asked } = noted;
  if (asked?.id === question?.id && asked?.opponent === question?.opponent) return noted;
  return { ...noted, asked: question && { id: question.id, opponent: question.opponent } };
}

/** Returns the recordings that are neither ranked nor skipped, nor gone. */
export function remaining(session: Session, { tiers, recordings }: Situation): readonly number[] {
  const skipped = skippedIn(session);
  return session.queue.filter(
    (id) => tierOf(tiers, id) < 0 && recordings.has(id) && !skipped.has(id),
  );
}

/** Returns the recordings that were skipped. */
export function skippedIn({ steps }: Session): ReadonlySet<number> {
  return new Set(
    steps.flatMap(({ ids, answer, order }) => (answer === null && order === null ? ids : [])),
  );
}

/** Returns what to ask next; null if nothing is left, or nothing to compare with. */
export function questionOf(session: Session, situation: Situation): Question | null {
  const { tiers, recordings } = situation;
  const left = remaining(session, situation);
  const { asked } = session;
  const [id] = left;
  if (id === undefined) return null;
  const isAsked =
    asked?.id === id && tierOf(tiers, asked.opponent) >= 0 && recordings.has(asked.opponent);
  const expected = expectationIn(session, tiers, id);
  // Answers that were enough are asked again if the recording lost its place elsewhere.
  const given = answersOn(session, id);
  const answers = placeAfter(tiers, given) ? [] : given;
  const tier = isAsked ? tierOf(tiers, asked.opponent) : nextTier(tiers, answers, expected);
  const opponent =
    tier === null
      ? undefined
      : isAsked
        ? asked.opponent
        : opponentIn(tiers[tier] ?? [], recordings);
  if (tier === null || opponent === undefined) return null;
  const number = session.queue.length - left.length + 1;
  return { id, opponent, tier, number, looks: looksLeft(tiers, answers, expected) };
}

/** Returns the questions that may follow, so that their games can be loaded in advance. */
export function questionsAfter(session: Session, situation: Situation): readonly Question[] {
  return (["better", "equal", "worse"] as const).flatMap((verdict) => {
    const next = answer(session, situation, verdict);
    return questionOf(next.session, { ...situation, tiers: next.tiers }) ?? [];
  });
}

/** A session after a step, and the order with what that placed. */
interface Outcome {
  readonly session: Session;
  readonly tiers: Tiers;
}

/** Answers the question; places the recording if that decides. */
export function answer(session: Session, situation: Situation, verdict: Verdict): Outcome {
  const { tiers } = situation;
  const asked = questionOf(session, situation);
  if (!asked) return { session, tiers };
  const { id, opponent } = asked;
  const given: Answer = { opponent, verdict };
  const to = placeAfter(tiers, [...answersOn(session, id), given]);
  const order = to && place(tiers, id, to);
  return after(session, situation, { ids: [id], answer: given, order });
}

/** Leaves the recording unranked. */
export function skip(session: Session, situation: Situation): Outcome {
  const ids = remaining(session, situation).slice(0, 1);
  return after(session, situation, { ids, answer: null, order: null });
}

/** Puts the recording, or all that are left, into a new tier below the worst. */
export function putBelow(session: Session, situation: Situation, which: "this" | "all"): Outcome {
  const { tiers } = situation;
  const left = remaining(session, situation);
  const ids = which === "all" ? left : left.slice(0, 1);
  const order = placeAll(tiers, ids, { kind: "gap", before: tiers.length });
  return after(session, situation, { ids, answer: null, order });
}

/** Returns the session before its last step; the order is the caller's to take back. */
export function withoutLast(session: Session): Session {
  return { ...session, steps: session.steps.slice(0, -1), asked: null };
}

function after(session: Session, situation: Situation, step: Step): Outcome {
  const tiers = step.order ?? situation.tiers;
  const next = { ...session, steps: [...session.steps, step], asked: null };
  return { session: asking(next, { ...situation, tiers }), tiers };
}

/** Notes what is expected of the recording whose turn it is. */
function withOpinion(session: Session, situation: Situation): Session {
  const [id] = remaining(session, situation);
  if (id === undefined || session.opinions.has(id)) return session;
  const opinion = situation.opinions.get(id) ?? null;
  return { ...session, opinions: new Map([...session.opinions, [id, opinion]]) };
}

function expectationIn({ opinions }: Session, tiers: Tiers, id: number): Expectation | null {
  const opinion = opinions.get(id);
  return opinion ? expectationOf(tiers, opinion) : null;
}

function answersOn({ steps }: Session, id: number): readonly Answer[] {
  return steps.flatMap(({ ids, answer }) => (ids[0] === id && answer ? [answer] : []));
}

/** Returns the recording that stands for a tier: a person's own if there is one. */
function opponentIn(
  tier: readonly number[],
  recordings: ReadonlyMap<number, LibraryEntry>,
): number | undefined {
  const known = tier.flatMap((id) => recordings.get(id) ?? []);
  const own = known.filter(({ borrowed }) => !borrowed);
  return (own.find(({ source }) => source === "person") ?? own[0] ?? known[0])?.id;
}
