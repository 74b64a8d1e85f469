import { t } from "@lingui/core/macro";
import { Plural, Trans } from "@lingui/react/macro";

import type { Behaviour, Recording } from "@/api/types";
import { ComparedGames } from "@/components/in-step/ComparedGames";

import type { Verdict } from "./search";
import type { Question } from "./session";
import { Side } from "./Side";
import type { Comparing } from "./use-comparing";

interface ComparisonProps {
  comparing: Comparing;
  question: Question;
  /** The recording that is to be placed. */
  game: Recording;
  /** The ranked one that it is compared with. */
  opponent: Recording;
  /** The recordings that may be shown next. */
  upcoming: readonly Recording[];
  behaviour: Behaviour;
  nTiers: number;
  nGames: number;
}

const VERDICTS = { first: "better", equal: "equal", second: "worse" } satisfies Record<
  string,
  Verdict
>;

/** A game that is to be placed beside a ranked one, and the answers. */
export function Comparison(props: ComparisonProps) {
  const { comparing, question, game, opponent, upcoming, behaviour, nTiers, nGames } = props;
  const { number, looks, tier } = question;
  const tierNumber = tier + 1;
  const { nLeft } = comparing;
  const allBelow = {
    label: t`All ${nLeft} left below the worst`,
    onAct: () => comparing.putBelow("all"),
  };
  return (
    <ComparedGames
      question={t`Which is better?`}
      progress={
        <Trans>
          Game {number} of {nGames},{" "}
          <Plural value={looks} one="about # more look" other="about # more looks" />
        </Trans>
      }
      games={[game, opponent]}
      upcoming={upcoming}
      side={(place, stage) => (
        <Side
          {...stage}
          behaviour={behaviour}
          recording={place === 0 ? game : opponent}
          part={place === 0 ? t`to be placed` : t`tier ${tierNumber} of ${nTiers}`}
        />
      )}
      words={(stacked) => ({
        first: stacked ? t`Upper is better` : t`Left is better`,
        equal: t`Equally good`,
        second: stacked ? t`Lower is better` : t`Right is better`,
      })}
      busy={comparing.busy}
      canUndo={comparing.canUndo}
      onAnswer={(answer) => comparing.answer(VERDICTS[answer])}
      onUndo={comparing.undo}
      further={[
        { label: t`Skip`, shortcut: "S", onAct: comparing.skip },
        { label: t`Below the worst`, shortcut: "W", onAct: () => comparing.putBelow("this") },
        ...(nLeft > 1 ? [allBelow] : []),
      ]}
    />
  );
}
