import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { BlindComparison } from "@/api/types";
import { type Answer, ComparedGames } from "@/components/in-step/ComparedGames";
import { ScreenInStep } from "@/components/in-step/ScreenInStep";

import { type Blind, gamesOf } from "./use-blind";

interface BlindPairProps {
  blind: Blind;
  comparison: BlindComparison;
}

const ANSWERS = { first: "left", equal: "equal", second: "right" } as const satisfies Record<
  Answer,
  string
>;

/** Two games of which nothing is told but what they show. */
export function BlindPair({ blind, comparison }: BlindPairProps) {
  const { n_pairs: nPairs, answers } = comparison;
  const number = answers.length + 1;
  const games = gamesOf(comparison, number);
  const names = [t`the left game`, t`the right game`] as const;
  return (
    <ComparedGames
      question={t`Which is closer to what you meant?`}
      progress={
        <span role="status">
          <Trans>
            Pair {number} of {nPairs}
          </Trans>
        </span>
      }
      games={games}
      upcoming={number < nPairs ? gamesOf(comparison, number + 1) : []}
      side={(place, stage) => <ScreenInStep {...stage} game={games[place]} name={names[place]} />}
      words={(stacked) => ({
        first: stacked ? t`Upper is closer` : t`Left is closer`,
        equal: t`Equally close`,
        second: stacked ? t`Lower is closer` : t`Right is closer`,
      })}
      busy={blind.busy}
      canUndo={answers.length > 0}
      onAnswer={(answer) => blind.answer(ANSWERS[answer])}
      onUndo={() => {
        if (answers.length > 0) blind.answer("taken back");
      }}
      further={
        answers.length > 0
          ? [{ label: t`Stop here and show who played which`, onAct: () => blind.answer("ended") }]
          : []
      }
    />
  );
}
