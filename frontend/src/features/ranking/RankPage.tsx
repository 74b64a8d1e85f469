import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { useMemo } from "react";
import { useLocation, useSearchParams } from "react-router";

import { borrowedQuery, useLibrary } from "@/api/library";
import type { Behaviour, LibraryEntry, Ranking } from "@/api/types";
import { ButtonLink } from "@/components/controls/Button";
import { Empty, Failed, Loading } from "@/components/feedback/States";
import { rankingQuery } from "@/features/ranking/order/rankings";
import { useRankingSaver } from "@/features/ranking/order/use-ranking";
import { useGame } from "@/games/game";
import { whyUnrankable } from "@/lib/recordings";
import { selectedBy } from "@/lib/selection";

import { RankingDesk } from "./RankingDesk";
import { TakeOver } from "./TakeOver";

/** Ranks the recordings of a behaviour into tiers, best to worst. */
export function RankPage({ behaviour }: { behaviour: Behaviour }) {
  const ranking = useQuery(rankingQuery(behaviour.id));
  const library = useLibrary(behaviour.id);
  const borrowed = useQuery(borrowedQuery(behaviour.id));
  const { entries, isWhole } = library;
  const rankable = useMemo(
    () => withBorrowed(entries ?? [], borrowed.data ?? []),
    [entries, borrowed.data],
  );
  // What is selected or compared at once may be among any.
  const asksForAny = selectedBy(useLocation().state).length > 0;
  const needsAny = useSearchParams()[0].has("compare") || asksForAny;
  const error = ranking.error ?? library.error ?? borrowed.error;
  if (error && !(ranking.data && isWhole && borrowed.data)) {
    return (
      <Failed
        what={t`The ranking`}
        error={error}
        onRetry={() => {
          void ranking.refetch();
          void library.refetch();
          void borrowed.refetch();
        }}
      />
    );
  }
  const isNothing =
    ranking.data?.tiers.length === 0 && !rankable.some((one) => whyUnrankable(one) === null);
  if (!ranking.data || !entries || !borrowed.data || (!isWhole && (needsAny || isNothing)))
    return <Loading what={t`the ranking`} rows={4} />;
  if (isNothing)
    return <NothingToRank behaviour={behaviour} ranking={ranking.data} borrowed={borrowed.data} />;
  return (
    <RankingDesk
      key={behaviour.id}
      behaviour={behaviour}
      ranking={ranking.data}
      recordings={rankable}
      isWhole={isWhole}
    />
  );
}

/** Returns a behaviour's recordings and those it has borrowed, newest first. */
function withBorrowed(
  own: readonly LibraryEntry[],
  borrowed: readonly LibraryEntry[],
): readonly LibraryEntry[] {
  if (borrowed.length === 0) return own;
  return [...own, ...borrowed].sort((a, b) => b.id - a.id);
}

interface NothingToRankProps {
  behaviour: Behaviour;
  ranking: Ranking;
  borrowed: readonly LibraryEntry[];
}

function NothingToRank({ behaviour, ranking, borrowed }: NothingToRankProps) {
  const [, saver] = useRankingSaver(ranking);
  const { picture_url: picture } = useGame();
  return (
    <Empty
      title={t`Nothing to rank yet`}
      picture={picture}
      actions={
        <ButtonLink kind="primary" to={`/behaviours/${behaviour.id}/play`}>
          <Trans>Play a game</Trans>
        </ButtonLink>
      }
    >
      <p>
        <Trans>Games that you keep appear here. Two are enough to begin with.</Trans>
      </p>
      <TakeOver
        behaviour={behaviour}
        recordings={borrowed}
        onTaken={(tiers) => saver.change(tiers)}
      />
    </Empty>
  );
}
