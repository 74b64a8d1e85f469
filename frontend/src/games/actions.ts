/** Names of a game's buttons and actions, and the spans in which each button was held. */
import { t } from "@lingui/core/macro";

import type { TaughtGame } from "@/api/types";
import { listed } from "@/lib/format";

type Controls = Pick<TaughtGame, "actions" | "buttons" | "held">;

const buttonNames = (): Readonly<Record<string, string>> => ({
  left: t`left`,
  right: t`right`,
  up: t`up`,
  down: t`down`,
  fire: t`fire`,
});

/** Names a button, within a sentence. */
export function buttonName(button: string): string {
  return Object.hasOwn(buttonNames(), button) ? (buttonNames()[button] ?? button) : button;
}

/** Names an action by its number: the buttons held for it. */
export function actionName(action: number, { actions, buttons, held }: Controls): string {
  const bits = held[action];
  if (bits === undefined) return t`action ${action}`;
  const names = buttons.filter((_, bit) => bits & (1 << bit)).map(buttonName);
  if (names.length > 0) return listed(names);
  const name = actions[action]?.toLowerCase() ?? "";
  return name === "" || name === "noop" ? t`nothing` : name;
}

/** Returns the numbers of the actions, those to the left first, those to the right last. */
export function actionsInOrder({ buttons, held }: Controls): readonly number[] {
  const bit = (name: string) => (buttons.includes(name) ? 1 << buttons.indexOf(name) : 0);
  const [left, right] = [bit("left"), bit("right")];
  const side = (bits: number) => Number((bits & right) !== 0) - Number((bits & left) !== 0);
  return held
    .map((bits, action) => ({ action, side: side(bits), bits }))
    .sort((a, b) => a.side - b.side || a.bits - b.bits)
    .map(({ action }) => action);
}

/** A range of frames, both ends included. */
interface Span {
  readonly from: number;
  readonly to: number;
}

interface Lane {
  readonly button: string;
  readonly spans: readonly Span[];
}

/**
 * Names the action that led to a frame.
 *
 * @param taken `taken[f]` was executed in frame f + 1.
 */
export function describeAction(
  taken: readonly number[],
  frame: number,
  controls: Controls,
): string {
  if (frame <= 0) return t`the start`;
  const action = taken[frame - 1];
  return action === undefined ? t`none` : actionName(action, controls);
}

/** Returns the spans in which each button was held. */
export function lanesOf(taken: readonly number[], { buttons, held }: Controls): readonly Lane[] {
  return buttons.map((button, bit) => ({
    button,
    spans: spansOf(taken, (action) => ((held[action] ?? 0) & (1 << bit)) !== 0),
  }));
}

function spansOf(taken: readonly number[], isHeld: (action: number) => boolean): Span[] {
  const spans: Span[] = [];
  for (let at = 0; at < taken.length; at += 1) {
    if (!isHeld(taken[at] ?? -1)) continue;
    const from = at + 1;
    while (at + 1 < taken.length && isHeld(taken[at + 1] ?? -1)) at += 1;
    spans.push({ from, to: at + 1 });
  }
  return spans;
}
