/** The few figures that a result opens with. */
import { t } from "@lingui/core/macro";

import type { Behaviour, Interval, Measure, RunResults, TaughtGame } from "@/api/types";
import { summaryRows } from "@/features/results/games/summary-rows";
import { meanValue, measureSentence, unitOf } from "@/games/measures";
import type { Actor } from "@/lib/actors";
import { fixed, percent, wholeShare } from "@/lib/format";

const MOST = 5;

interface Value {
  readonly actor: Actor;
  readonly text: string;
  /** Where it is known, for the picture. */
  readonly interval: Interval | null;
}

export interface Figure {
  readonly name: string;
  /** The imitator's, or that of the reward. */
  readonly value: string;
  /** Those of others, to compare with. */
  readonly others: readonly Value[];
  /** The imitator's interval and the bounds of the axis; null without a picture. */
  readonly plot: {
    readonly interval: Interval;
    readonly low: number;
    readonly high: number;
  } | null;
}

/** Returns at most five figures of a run's imitator, what the behaviour asks for first. */
export function figuresOf(
  results: RunResults,
  behaviour: Behaviour,
  game: TaughtGame,
): readonly Figure[] {
  const summary = summaryFigures(results, behaviour, game);
  const measures = measureFigures(results, game);
  const [understood, elsewhere] = understoodFigures(results);
  const asked = behaviour.target
    ? [...summary, ...measures]
    : [...measures, ...understood, ...summary, ...elsewhere];
  // What people said of it comes first where nothing measures the behaviour, else second.
  const isMeasured = behaviour.target !== null || measures.length > 0;
  const others = asked.splice(isMeasured ? 1 : 0);
  return [...asked, ...blindFigure(results), ...others, ...agreement(results)].slice(0, MOST);
}

function blindFigure({ blind }: RunResults): Figure[] {
  if (!blind) return [];
  const { share, against } = blind;
  return [
    {
      name: t`Closer to what was meant (blind comparison)`,
      value: percent(share.mean, 0),
      others: against.map(({ opponent, wins, n }) => ({
        actor: opponent,
        text: t`${fixed(n - wins, Number.isInteger(wins) ? 0 : 1)} of ${n}`,
        interval: null,
      })),
      plot: { interval: share, low: 0, high: 1 },
    },
  ];
}

interface Shares {
  readonly imitator: Interval | null;
  readonly clone: Interval | null;
  readonly best: Interval | null;
}

/**
 * How much games show of what Tril understood, as shares of a whole game as good as the best; and how
 * far they are from the best games in where things are and when.
 */
function understoodFigures({ run: { headline } }: RunResults): [Figure[], Figure[]] {
  const figureOf = (name: string, shares: Shares | null | undefined): Figure[] => {
    if (!shares?.imitator) return [];
    const { imitator, clone, best } = shares;
    const others = [
      { actor: "clone" as const, interval: clone },
      { actor: "person" as const, interval: best },
    ].flatMap(({ actor, interval }) =>
      interval ? [{ actor, text: shareOf(actor, wholeShare(interval.mean)), interval }] : [],
    );
    const high = Math.max(1, imitator.high, ...others.map(({ interval }) => interval.high));
    const plot = { interval: imitator, low: 0, high };
    return [{ name, value: wholeShare(imitator.mean), others, plot }];
  };
  return [
    figureOf(t`Worth by what Tril understood (100%: a full game)`, headline?.understood),
    figureOf(t`Time spent elsewhere than the best games, while they last`, headline?.elsewhere),
  ];
}

/** Says of a person's figure that it is of the best games, where measures are of all that were ranked. */
function shareOf(actor: Actor, share: string): string {
  return actor === "person" ? t`${share} in the best games` : share;
}

function summaryFigures(
  { summaries }: RunResults,
  { target, ordered }: Behaviour,
  { max_steps: maxSteps }: TaughtGame,
): Figure[] {
  const of = (name: "imitator" | "clone") =>
    summaries.find((one) => one.policy === name && one.action_selection === "greedy")?.summary ??
    null;
  return summaryRows(of("imitator"), of("clone"), target?.length ?? null, ordered, maxSteps)
    .filter(({ key }) => key !== "predicted_return")
    .flatMap(({ name, imitator, clone, write, low, high }) =>
      imitator
        ? [
            {
              name,
              value: write(imitator.mean),
              others: clone
                ? [{ actor: "clone" as const, text: write(clone.mean), interval: clone }]
                : [],
              plot: { interval: imitator, low, high },
            },
          ]
        : [],
    );
}

function measureFigures({ measures }: RunResults, game: TaughtGame): Figure[] {
  return measures.flatMap(({ measure, imitator, clone, person }) =>
    imitator
      ? [
          {
            name: measureSentence(measure, game),
            value: shortMean(imitator.mean, measure),
            others: [
              { actor: "clone" as const, mean: clone },
              { actor: "person" as const, mean: person },
            ].flatMap(({ actor, mean }) =>
              mean
                ? [{ actor, text: ofAll(actor, shortMean(mean.mean, measure)), interval: null }]
                : [],
            ),
            plot: null,
          },
        ]
      : [],
  );
}

function ofAll(actor: Actor, mean: string): string {
  return actor === "person" ? t`${mean} in all ranked games` : mean;
}

/** Writes a mean in as little room as a figure has: its name says that a share is of the time. */
function shortMean(mean: number, measure: Measure): string {
  return unitOf(measure) === "share" ? percent(mean, 0) : meanValue(mean, measure);
}

function agreement({ check }: RunResults): Figure[] {
  if (!check) return [];
  const name = t`Agreement of R with the ranking, 1 at most`;
  return [{ name, value: fixed(check.tau, 2), others: [], plot: null }];
}
