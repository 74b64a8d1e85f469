/** Describes how games came out: their results, lengths and ends. */
import { plural, t } from "@lingui/core/macro";

import type { Behaviour, MeasuredValue, TaughtGame } from "@/api/types";
import { measured, seconds } from "@/lib/format";
import { strayWords } from "@/lib/game/items";

import { metText } from "./measures";
import { capitalised, wordsOf } from "./words";

interface Score {
  readonly targets: number | null;
  readonly strays: number | null;
  readonly order_errors: number | null;
}

interface Course {
  readonly n_frames: number;
  readonly n_steps: number;
  readonly end: string | null;
  readonly state: "playing" | "unfinished" | "finished" | "kept";
}

/** Describes why a game ended. */
export function describeEnd(end: string | null, game: TaughtGame): string {
  if (end === null) return t`ended early`;
  if (kindOf(end, game) === "time")
    return plural(game.max_steps, { one: "survived its # step", other: "survived all # steps" });
  return wordsOf(game).ends()[end] ?? end.replaceAll("_", " ");
}

interface Result extends Score {
  readonly score?: number | null;
  readonly measured?: readonly MeasuredValue[];
}

/**
 * Describes the result of a game: "5 of 6 targets, 1 stray, 1 of 2 measures met". Without a target
 * nothing is said of items: their number says nothing of the behaviour. Empty if there is nothing.
 */
export function describeResult(
  recording: Result,
  { target, measures }: Pick<Behaviour, "target" | "measures">,
  game: TaughtGame,
): string {
  const met = metText(recording.measured ?? [], measures);
  return [...scoreParts(recording, target?.length, game), met].filter(Boolean).join(", ");
}

function scoreParts(
  { targets, strays, order_errors: errors, score }: Result,
  nTargets: number | undefined,
  game: TaughtGame,
): readonly string[] {
  if (targets === null || strays === null || nTargets === undefined) {
    if (game.items || typeof score !== "number") return [];
    return [t`Score ${measuredScore(score)}`];
  }
  return [
    t`${targets} of ${nTargets} targets`,
    strayWords(strays),
    errors ? plural(errors, { one: "# hit out of order", other: "# hits out of order" }) : "",
  ];
}

function measuredScore(score: number): string {
  return Number.isInteger(score) ? String(score).replace("-", "−") : measured(score);
}

/** Describes a game: "survived all 300 steps, 20.0 s" or "139 steps, 9.3 s, a life was lost". */
export function describeCourse(recording: Course, game: TaughtGame): string {
  const { n_frames: frames, end, state } = recording;
  const length = describeLength(recording, game);
  if (state === "unfinished") return t`${length}, its page was left`;
  const ending = describeEnd(end, game);
  if (kindOf(end, game) === "time") return `${ending}, ${seconds(frames / game.frame_rate_hz)}`;
  return `${length}, ${ending}`;
}

/** Describes the length of a game: "300 steps, 20.0 s". */
function describeLength({ n_frames: frames, n_steps }: Course, game: TaughtGame): string {
  const steps = plural(n_steps, { one: "# step", other: "# steps" });
  return `${steps}, ${seconds(frames / game.frame_rate_hz)}`;
}

/** Says how a game ended, and when: "The game was over after 9.3 s". */
export function endSentence(
  { reason, frame }: { readonly reason: string | null; readonly frame: number },
  game: TaughtGame,
): string {
  const time = seconds(frame / game.frame_rate_hz);
  if (reason === null) return t`Stopped after ${time}`;
  const ending = capitalised(describeEnd(reason, game));
  return kindOf(reason, game) === "time" ? ending : t`${ending} after ${time}`;
}

/** Whether a game ended by death, or was lost in another way. */
export function isLost(end: string | null, game: TaughtGame): boolean {
  const kind = kindOf(end, game);
  return kind === "death" || kind === "failed";
}

/**
 * Says what a game lacks to be perfect: "it missed 2 targets"; empty if nothing. That it was lost
 * counts where the behaviour asks for targets or for survival.
 */
export function imperfections(
  { targets, strays, order_errors: errors, end }: Score & { readonly end: string | null },
  { target, measures }: Pick<Behaviour, "target" | "measures">,
  game: TaughtGame,
): readonly string[] {
  const missed = target === null || targets === null ? 0 : target.length - targets;
  const mustSurvive = target !== null || measures.some(({ kind }) => kind === "alive");
  return [
    ...(missed > 0
      ? [plural(missed, { one: "it missed # target", other: "it missed # targets" })]
      : []),
    ...(strays ? [plural(strays, { one: "it hit # stray", other: "it hit # strays" })] : []),
    ...(errors
      ? [plural(errors, { one: "# hit came out of order", other: "# hits came out of order" })]
      : []),
    ...(mustSurvive && kindOf(end, game) === "death"
      ? [t`it was lost: ${describeEnd(end, game)}`]
      : []),
  ];
}

function kindOf(end: string | null, { ends }: TaughtGame): string | null {
  return ends.find(({ name }) => name === end)?.kind ?? null;
}
