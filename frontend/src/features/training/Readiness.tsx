import { t } from "@lingui/core/macro";
import { Plural, Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { Link, useSearchParams } from "react-router";

import { borrowedQuery } from "@/api/library";
import type { Behaviour } from "@/api/types";
import { Notice } from "@/components/feedback/States";
import { continuing, withSearch } from "@/lib/runs";

interface ReadinessProps {
  behaviour: Behaviour;
  missing: string | null;
  /** Whether the run trains on the scripted example instead. */
  example: boolean;
}

/** What the run would learn from, or what is missing. */
export function Readiness({ behaviour, missing, example }: ReadinessProps) {
  const at = `/behaviours/${behaviour.id}`;
  const rank = withSearch(`${at}/rank`, continuing(useSearchParams()[0]));
  const { data: borrowed = [] } = useQuery(borrowedQuery(behaviour.id));
  const nBorrowed = borrowed.filter(({ ranked }) => ranked).length;
  if (missing === null) {
    return (
      <Notice tone="calm" icon="check">
        <p>
          <Plural
            value={behaviour.n_ranked}
            one="# ranked game goes into the run"
            other="# ranked games go into the run"
          />
          {nBorrowed > 0 && <Trans>, {nBorrowed} of them borrowed</Trans>}.{" "}
          <Plural
            value={behaviour.n_perfect}
            _0="No game has a star: the clone copies the best ranked ones."
            one="The clone copies the one with a star."
            other="The clone copies the # with a star."
          />{" "}
          <Link to={rank}>
            <Trans>Look at the ranking</Trans>
          </Link>
        </p>
      </Notice>
    );
  }
  if (example) {
    return (
      <Notice tone="calm">
        <p>
          <Trans>
            You have not played yet, so this run uses an example: its games come from a scripted
            player, not a person, and Tril ranks them.
          </Trans>
        </p>
        <Link to={`${at}/play`}>
          <Trans>Play yourself instead</Trans>
        </Link>
      </Notice>
    );
  }
  return (
    <Notice>
      <p>{missing}</p>
      <Link to={rank}>
        <Trans>Go to Rank</Trans>
      </Link>
    </Notice>
  );
}

/** What prevents a run; null if nothing does. */
export function missingFor(behaviour: Behaviour): string | null {
  if (behaviour.n_ranked < 2) return t`Rank at least two games, in two tiers or more.`;
  return null;
}
