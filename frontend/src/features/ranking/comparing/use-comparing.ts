import { plural, t } from "@lingui/core/macro";
import { useEffect, useState } from "react";

import { describePosition } from "@/features/ranking/board/places";
import { place, sameOrder, tierOf, type Tiers } from "@/features/ranking/order/order";
import type { RankingSaver } from "@/features/ranking/order/saver";
import { dropDraft, readDraft, writeDraft } from "@/lib/browser/drafts";
import { useRecordingName } from "@/features/ranking/recording-names";

import type { Verdict } from "./search";
import {
  answer,
  asking,
  begin,
  openAnswers,
  type OpenAnswers,
  type Question,
  putBelow,
  questionOf,
  questionsAfter,
  remaining,
  type Session,
  type Situation,
  skip,
  skippedIn,
  withoutLast,
} from "./session";

type NameOf = (id: number) => string;

export interface Comparing {
  readonly question: Question | null;
  /** The questions that may follow. */
  readonly upcoming: readonly Question[];
  /** How many recordings have no place yet and were not skipped. */
  readonly nLeft: number;
  readonly nPlaced: number;
  readonly nSkipped: number;
  readonly canUndo: boolean;
  /** Whether something that was placed is being taken back; nothing can be done meanwhile. */
  readonly busy: boolean;
  /** What happened last and what is asked now, for screen readers. */
  readonly spoken: string;
  readonly answer: (verdict: Verdict) => void;
  readonly skip: () => void;
  readonly putBelow: (which: "this" | "all") => void;
  readonly undo: () => void;
}

/** Places recordings by comparing them; each that gets its place is one change of the ranking. */
export function useComparing(
  queue: readonly number[],
  situation: Situation,
  saver: RankingSaver,
  /** The name of the draft that keeps answers which have not led to a place yet. */
  draft: string,
): Comparing {
  const [session, setSession] = useState(() =>
    begin(queue, situation, readDraft(draft) as OpenAnswers | undefined),
  );
  const [busy, setBusy] = useState(false);
  const [told, setTold] = useState("");
  const nameOf = useRecordingName();
  const { tiers } = situation;
  // What is being taken back changes the order once more.
  const current = busy ? session : asking(session, situation);
  if (current !== session) setSession(current);
  const question = questionOf(current, situation);
  const open = JSON.stringify(openAnswers(current, situation));
  useEffect(() => {
    if (open === "[]") dropDraft(draft);
    else writeDraft(draft, JSON.parse(open));
  }, [draft, open]);
  const isRanked = (id: number) => tierOf(tiers, id) >= 0;

  function go(next: { session: Session; tiers: Tiers }) {
    if (busy) return;
    setSession(next.session);
    setTold(describeLast(next.session, next.tiers, nameOf));
    if (next.tiers !== tiers) saver.change(next.tiers);
  }

  async function undo() {
    const last = session.steps.at(-1);
    if (busy || !last) return;
    setSession(withoutLast(session));
    setTold(t`Taken back.`);
    if (!last.order) return;
    setBusy(true);
    await takeBack(saver, last.ids, last.order);
    setBusy(false);
  }

  return {
    question,
    upcoming: question ? questionsAfter(session, situation) : [],
    nLeft: remaining(session, situation).length,
    nPlaced: queue.filter(isRanked).length,
    nSkipped: [...skippedIn(session)].filter((id) => !isRanked(id)).length,
    canUndo: session.steps.length > 0,
    busy,
    spoken: [told, question ? describeQuestion(question, nameOf) : ""].filter(Boolean).join(" "),
    answer: (verdict) => go(answer(session, situation, verdict)),
    skip: () => go(skip(session, situation)),
    putBelow: (which) => go(putBelow(session, situation, which)),
    undo: () => void undo(),
  };
}

/** Takes recordings off the board: by an undo if putting them there was the last change. */
async function takeBack(saver: RankingSaver, ids: readonly number[], order: Tiers): Promise<void> {
  if (sameOrder(saver.snapshot().tiers, order)) await saver.step("undo");
  // It was changed elsewhere in the meantime, or can't be saved at the moment.
  const { tiers } = saver.snapshot();
  saver.change(ids.reduce((now, id) => place(now, id, { kind: "tray" }), tiers));
}

function describeLast({ steps }: Session, tiers: Tiers, nameOf: NameOf): string {
  const last = steps.at(-1);
  const [id] = last?.ids ?? [];
  if (!last || id === undefined) return "";
  if (last.ids.length > 1) {
    const n = last.ids.length;
    return plural(n, {
      one: "# recording put below the worst.",
      other: "# recordings put below the worst.",
    });
  }
  if (last.order) return `${nameOf(id)}: ${describePosition(tiers, id)}.`;
  return last.answer ? "" : t`${nameOf(id)} stays unranked.`;
}

function describeQuestion({ id, opponent, tier }: Question, nameOf: NameOf): string {
  return t`Which is better: ${nameOf(id)}, or ${nameOf(opponent)} of tier ${tier + 1}?`;
}
