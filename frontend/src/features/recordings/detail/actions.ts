/** Names of a recording's actions, and the spans in which each key was held. */
import { t } from "@lingui/core/macro";

import { actionName } from "@/lib/game/actions";

const FIRING: ReadonlySet<number> = new Set([1, 4, 5]);
const RIGHT: ReadonlySet<number> = new Set([2, 4]);
const LEFT: ReadonlySet<number> = new Set([3, 5]);

/** A range of frames, both ends included. */
interface Span {
  readonly from: number;
  readonly to: number;
}

interface Lane {
  readonly name: string;
  readonly spans: readonly Span[];
}

/**
 * Names the action that led to a frame.
 *
 * @param actions `actions[f]` was executed in frame f + 1.
 */
export function describeAction(actions: readonly number[], frame: number): string {
  if (frame <= 0) return t`the start`;
  const action = actions[frame - 1];
  return action === undefined ? t`none` : actionName(action);
}

/** Returns the spans in which each key was held. */
export function lanesOf(actions: readonly number[]): readonly Lane[] {
  return [
    { name: "left", spans: spansOf(actions, LEFT) },
    { name: "right", spans: spansOf(actions, RIGHT) },
    { name: "fire", spans: spansOf(actions, FIRING) },
  ];
}

function spansOf(actions: readonly number[], held: ReadonlySet<number>): Span[] {
  const spans: Span[] = [];
  for (let at = 0; at < actions.length; at += 1) {
    if (!held.has(actions[at] ?? -1)) continue;
    const from = at + 1;
    while (held.has(actions[at + 1] ?? -1)) at += 1;
    spans.push({ from, to: at + 1 });
  }
  return spans;
}
