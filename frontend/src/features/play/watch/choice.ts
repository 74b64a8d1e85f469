/** What is watched: who plays, from which start. It is the page's address. */
import { t } from "@lingui/core/macro";

export type Policy = "imitator" | "clone";
export type Selection = "greedy" | "sampled" | "sticky";

/** Who plays a game, as the address and the server name it: "imitator.greedy". */
export type Player = `${Policy}.${Selection}`;

const POLICIES: readonly Policy[] = ["imitator", "clone"];
const SELECTIONS: readonly Selection[] = ["greedy", "sampled", "sticky"];

export const PLAYERS: readonly Player[] = POLICIES.flatMap((policy) =>
  SELECTIONS.map((selection): Player => `${policy}.${selection}`),
);
export const MAX_PLAYERS = 4;
export const N_STARTS = 32;
const DRAWS = 2 ** 31;

export interface Choice {
  /** One to four, each with a game of its own. */
  readonly players: readonly Player[];
  /** The evaluation start; null for one that is drawn. */
  readonly start: number | null;
  /** Seeds the start and its opening if they are drawn. */
  readonly draw: number;
}

export function policyOf(player: Player): Policy {
  return player.startsWith("imitator") ? "imitator" : "clone";
}

/** Names a player: "Imitator, greedy". */
export function playerName(player: Player): string {
  const selection = player.slice(player.indexOf(".") + 1) as Selection;
  const how = { greedy: t`greedy`, sampled: t`sampled`, sticky: t`sticky` }[selection];
  return `${policyOf(player) === "imitator" ? t`Imitator` : t`Clone`}, ${how}`;
}

/** Reads a choice from the page's address; what makes no sense there is replaced. */
export function readChoice(search: URLSearchParams): Choice {
  const asked = search
    .getAll("player")
    .flatMap((name) => PLAYERS.find((one) => one === name) ?? []);
  const draw = wholeIn(search.get("draw"), DRAWS);
  return {
    players: asked.length > 0 ? asked.slice(0, MAX_PLAYERS) : ["imitator.greedy"],
    start: draw === null ? (wholeIn(search.get("start"), N_STARTS) ?? 0) : null,
    draw: draw ?? 0,
  };
}

export function writeChoice({ players, start, draw }: Choice): URLSearchParams {
  const search = new URLSearchParams(players.map((player) => ["player", player]));
  if (start === null) search.set("draw", String(draw));
  else search.set("start", String(start));
  return search;
}

/** Returns the choice with the start after this one: the next number, or a new draw. */
export function nextStart(choice: Choice): Choice {
  if (choice.start === null) return newStart(choice);
  return { ...choice, start: (choice.start + 1) % N_STARTS };
}

/** Returns the choice with a start that is drawn anew. */
export function newStart(choice: Choice): Choice {
  return { ...choice, start: null, draw: Math.floor(Math.random() * DRAWS) };
}

/** Returns the player to add: the first that does not play yet, else another of the last. */
export function furtherPlayer(players: readonly Player[]): Player {
  return PLAYERS.find((player) => !players.includes(player)) ?? "imitator.sampled";
}

function wholeIn(text: string | null, below: number): number | null {
  if (text === null || !/^\d{1,10}$/.test(text)) return null;
  const number = Number(text);
  return number < below ? number : null;
}

/** Whose attention is shown: the reward's, or that of each game's policy. */
export type LookingNetwork = "reward" | "policy";
