import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { useMemo } from "react";

import { borrowedQuery, libraryQuery } from "@/api/library";
import type { Behaviour, LibraryEntry } from "@/api/types";
import { ButtonLink } from "@/components/controls/Button";
import { Empty, Failed, Loading } from "@/components/feedback/States";
import { rankingQuery } from "@/features/ranking/order/rankings";
import { whyUnrankable } from "@/lib/recordings";

import { RankingDesk } from "./RankingDesk";

/** Ranks the recordings of a behaviour into tiers, best to worst. */
export function RankPage({ behaviour }: { behaviour: Behaviour }) {
  const ranking = useQuery(rankingQuery(behaviour.id));
  const recordings = useQuery(libraryQuery(behaviour.id));
  const borrowed = useQuery(borrowedQuery(behaviour.id));
  const rankable = useMemo(
    () => withBorrowed(recordings.data?.entries ?? [], borrowed.data ?? []),
    [recordings.data, borrowed.data],
  );
  const error = ranking.error ?? recordings.error ?? borrowed.error;
  if (error && !(ranking.data && recordings.data && borrowed.data)) {
    return (
      <Failed
        what={t`The ranking`}
        error={error}
        onRetry={() => {
          void ranking.refetch();
          void recordings.refetch();
          void borrowed.refetch();
        }}
      />
    );
  }
  if (!ranking.data || !recordings.data || !borrowed.data)
    return <Loading what={t`the ranking`} rows={4} />;
  const { tiers } = ranking.data;
  if (tiers.length === 0 && !rankable.some((one) => whyUnrankable(one) === null))
    return <NothingToRank behaviour={behaviour} />;
  return (
    <RankingDesk
      key={behaviour.id}
      behaviour={behaviour}
      ranking={ranking.data}
      recordings={rankable}
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

function NothingToRank({ behaviour }: { behaviour: Behaviour }) {
  return (
    <Empty
      title={t`Nothing to rank yet`}
      actions={
        <ButtonLink kind="primary" to={`/behaviours/${behaviour.id}/play`}>
          <Trans>Play a game</Trans>
        </ButtonLink>
      }
    >
      <p>
        <Trans>Games that you keep appear here. Two are enough to begin with.</Trans>
      </p>
    </Empty>
  );
}
