import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { Link, useSearchParams } from "react-router";

import type { Behaviour, Recording } from "@/api/types";
import { ButtonLink } from "@/components/controls/Button";
import { Icon } from "@/components/controls/Icon";
import { RunName } from "@/components/RunName";
import { pairCount, type Tiers } from "@/features/ranking/order/order";
import { continuing, withSearch } from "@/lib/runs";
import { MAX_STEPS } from "@/lib/format";
import { cellKey } from "@/lib/game/aliens";
import { hitCells, isLost } from "@/lib/recordings";

import styles from "./Hints.module.css";

const GOOD_NUMBER = 12;

interface Hint {
  readonly id: string;
  readonly done: boolean;
  readonly text: string;
  /** Whether a run can be started without it. */
  readonly optional?: true;
}

/** Returns what training needs and whether it is there. */
function hintsFor(tiers: Tiers, recordings: readonly Recording[]): readonly Hint[] {
  const ranked = new Set(tiers.flat());
  const nRanked = ranked.size;
  const nBorrowed = recordings.filter((one) => one.borrowed && ranked.has(one.id)).length;
  const nPerfect = recordings.filter((one) => one.perfect).length;
  const pairs = pairCount(tiers);
  return [
    tiers.length >= 2
      ? {
          id: "tiers",
          done: true,
          text: plural(pairs, {
            one: "# comparison to learn from",
            other: "# comparisons to learn from",
          }),
        }
      : {
          id: "tiers",
          done: false,
          text: t`At least two tiers are needed: nothing can be learned from ties alone.`,
        },
    nPerfect >= 1
      ? { id: "perfect", done: true, text: t`${nPerfect} marked as perfect` }
      : {
          id: "perfect",
          done: false,
          optional: true,
          text: t`None is marked as perfect: the clone copies the best ranked ones. Mark others with their star.`,
        },
    nRanked >= GOOD_NUMBER
      ? { id: "number", done: true, text: rankedText(nRanked, nBorrowed) }
      : {
          id: "number",
          done: false,
          optional: true,
          text: t`${rankedText(nRanked, nBorrowed)}. About ${GOOD_NUMBER}, from perfect to hopeless, work well.`,
        },
    ...(nRanked >= GOOD_NUMBER ? missingKinds(tiers, recordings) : []),
  ];
}

/** Counts the ranked games, and says how many of them are no recordings of the behaviour. */
function rankedText(n: number, nBorrowed: number): string {
  const games = plural(n, { one: "# game ranked", other: "# games ranked" });
  return nBorrowed > 0 ? t`${games}, ${nBorrowed} of them borrowed` : games;
}

/** How many kinds are named at a time. */
const MAX_KINDS = 2;

/** Returns the kinds of games that a ranking of enough games lacks, and what to do about it. */
function missingKinds(tiers: Tiers, recordings: readonly Recording[]): readonly Hint[] {
  const ranked = new Set(tiers.flat());
  const games = recordings.filter(({ id }) => ranked.has(id));
  // Only a behaviour with target cells scores games.
  const scored = games.filter(({ targets }) => targets !== null);
  const kinds = scored.length > 0 ? missingOutcomes(scored) : [];
  return kinds.slice(0, MAX_KINDS).map((kind) => ({ ...kind, done: false, optional: true }));
}

const EARLY_STEPS = MAX_STEPS / 2;

/** Returns the outcomes that no scored game has, the most telling first. */
function missingOutcomes(
  games: readonly Recording[],
): { readonly id: string; readonly text: string }[] {
  const outcomes = [
    {
      id: "mixed",
      there: games.some(({ targets, strays }) => targets && strays),
      text: t`No ranked game hits a target and a stray. Play one that does: it shows what a stray costs.`,
    },
    {
      id: "survived",
      there: games.some(({ end }) => !isLost(end)),
      text: t`Every ranked game is lost. Play one that lasts to its end: it shows that surviving counts.`,
    },
    {
      id: "lost",
      there: games.some(({ end, n_steps }) => isLost(end) && n_steps < EARLY_STEPS),
      text: t`No ranked game is lost early. Play one in which the cannon is hit soon: it shows what that costs.`,
    },
    {
      id: "aliens",
      there: new Set(games.map(aliensHit)).size > 1,
      text: t`All ranked games hit the same aliens. Play some that hit others, or fewer: they show which ones count.`,
    },
  ];
  return outcomes.filter(({ there }) => !there);
}

/** Names the aliens that a game hit, in whatever order. */
function aliensHit(game: Recording): string {
  return hitCells(game).map(cellKey).sort().join(" ");
}

/** Whether a run can be started. */
function canTrain(tiers: Tiers, recordings: readonly Recording[]): boolean {
  return hintsFor(tiers, recordings).every(({ done, optional }) => done || optional);
}

/** What training needs, and the link to it once that is there. */
export function Hints({
  tiers,
  recordings,
  behaviour,
}: {
  tiers: Tiers;
  recordings: readonly Recording[];
  behaviour: Behaviour;
}) {
  const at = `/behaviours/${behaviour.id}`;
  const further = continuing(useSearchParams()[0]);
  const parentId = further.get("continue");
  return (
    <section className={styles.hints} aria-label={t`What training needs`}>
      <ul className={styles.hints}>
        {hintsFor(tiers, recordings).map((hint) => (
          <li key={hint.id} className={hint.done ? styles.ok : styles.open}>
            <Icon name={hint.done ? "check" : "alert"} />
            <span>{hint.text}</span>
          </li>
        ))}
        {parentId !== null && (
          <li>
            <Icon name="redo" />
            <span>
              <Trans>
                The next run continues <RunName id={parentId} />.
              </Trans>
            </span>
          </li>
        )}
      </ul>
      {canTrain(tiers, recordings) ? (
        <ButtonLink kind="primary" to={withSearch(`${at}/train`, further)}>
          <Trans>Continue to Train</Trans>
        </ButtonLink>
      ) : (
        <Link to={`${at}/play`}>
          <Trans>Play more games</Trans>
        </Link>
      )}
    </section>
  );
}
