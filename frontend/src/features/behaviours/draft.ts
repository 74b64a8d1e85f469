/** A behaviour as a form has it. */

import { t } from "@lingui/core/macro";

import type { Behaviour, BehaviourNew, Measure, ReadyMade, TaughtGame } from "@/api/types";
import { measured, whole } from "@/lib/format";
import type { Cell } from "@/lib/game/items";

export interface BehaviourDraft {
  readonly game: string;
  readonly name: string;
  readonly description: string;
  readonly hasTarget: boolean;
  readonly target: readonly Cell[];
  readonly ordered: boolean;
  /** The longest game in seconds, as typed; empty as the game has it. */
  readonly seconds: string;
  /** Name of the end rule; null as the game has it. */
  readonly endRule: string | null;
  readonly options: Readonly<Record<string, number>>;
  readonly hidden: Behaviour["settings"]["hidden"] | null;
  readonly measures: readonly Measure[];
}

/** The game that behaviours are of unless another one is chosen. */
export const DEFAULT_GAME = "space_invaders";

export const EMPTY_DRAFT: BehaviourDraft = {
  game: DEFAULT_GAME,
  name: "",
  description: "",
  hasTarget: false,
  target: [],
  ordered: false,
  seconds: "",
  endRule: null,
  options: {},
  hidden: null,
  measures: [],
};

type Described = Omit<ReadyMade, "slug">;

/** The form of a behaviour that exists, or that comes with a game. */
export function draftOf(behaviour: Described, game: TaughtGame): BehaviourDraft {
  const { name, description, target, ordered, settings } = behaviour;
  const cells = (target ?? []).map(([row, column]) => [row, column] as const);
  const steps = settings.max_steps ?? null;
  return {
    game: game.name,
    name,
    description,
    hasTarget: target !== null,
    target: cells,
    ordered,
    seconds: steps === null ? "" : String(Number(secondsOf(steps, game).toFixed(2))),
    endRule: settings.end_rule ?? null,
    options: settings.options,
    hidden: settings.hidden ?? null,
    measures: behaviour.measures,
  };
}

/** Returns how long so many steps of a game take. */
export function secondsOf(steps: number, game: TaughtGame): number {
  return (steps * game.frames_per_step) / game.frame_rate_hz;
}

/** Shortest games that can be asked for. */
const LEAST_SECONDS = 5;
const MOST_SECONDS = 400;

/** What is wrong with the length of games; null if nothing is. */
export function secondsProblem(typed: string, game: TaughtGame): string | null {
  if (typed.trim() === "") return null;
  const most = Math.min(MOST_SECONDS, secondsOf(game.longest_steps, game));
  const seconds = readSeconds(typed);
  return seconds >= LEAST_SECONDS && seconds <= most
    ? null
    : t`Type a number of seconds from ${LEAST_SECONDS} to ${whole(most)}.`;
}

function readSeconds(typed: string): number {
  return Number(typed.trim().replace(",", "."));
}

/** Names the length that a game has by itself. */
export function ownSeconds(game: TaughtGame): string {
  return measured(secondsOf(game.max_steps, game)).replace(/[.,]0+$/, "");
}

/** The behaviour that a form describes. */
export function behaviourOf(draft: BehaviourDraft, game: TaughtGame): BehaviourNew {
  const hasTarget = draft.hasTarget && game.items !== null;
  const isTimed = draft.seconds.trim() !== "";
  const steps = (readSeconds(draft.seconds) * game.frame_rate_hz) / game.frames_per_step;
  return {
    game: game.name,
    name: draft.name.trim(),
    description: draft.description.trim(),
    target: hasTarget ? draft.target.map(([row, column]: Cell) => [row, column]) : null,
    ordered: hasTarget && draft.ordered,
    settings: {
      max_steps: isTimed ? Math.round(steps) : null,
      end_rule: draft.endRule,
      options: draft.options,
      hidden: draft.hidden ?? null,
    },
    measures: [...draft.measures],
  };
}

type Named = Pick<Behaviour, "id" | "name">;

/** As the server has it, in characters. */
const MAX_NAME_LENGTH = 120;

/** The form of a copy: its name is free. */
export function copyOf(
  behaviour: Behaviour,
  others: readonly Named[],
  game: TaughtGame,
): BehaviourDraft {
  const draft = draftOf(behaviour, game);
  // Leaves room for the other words and a number.
  const start = draft.name.slice(0, 90);
  const first = game.items ? t`${start} with another target` : t`${start}, played otherwise`;
  let name = first;
  for (let number = 2; namesake(name, others); number += 1) name = `${first} (${number})`;
  return { ...draft, name, hasTarget: game.items !== null };
}

/** What is wrong with the name of a behaviour; null if nothing is. */
export function nameProblem(
  name: string,
  others: readonly Named[],
  besides?: number,
): string | null {
  const length = Array.from(name.trim()).length;
  if (length === 0) return t`Give the behaviour a name.`;
  if (length > MAX_NAME_LENGTH)
    return t`Use at most ${MAX_NAME_LENGTH} characters; these are ${length}.`;
  const taken = namesake(name, others, besides);
  return taken ? t`There is a behaviour named ${taken.name} already. Choose another name.` : null;
}

/** Returns the behaviour that has a name already. */
function namesake(name: string, others: readonly Named[], besides?: number): Named | undefined {
  return others.find((one) => one.id !== besides && compared(one.name) === compared(name));
}

function compared(name: string): string {
  return name.normalize("NFKC").trim().toLowerCase();
}
