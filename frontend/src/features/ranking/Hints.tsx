import { plural, t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { Link, useSearchParams } from "react-router";

import type { Behaviour, LibraryEntry } from "@/api/types";
import { ButtonLink } from "@/components/controls/Button";
import { Icon } from "@/components/controls/Icon";
import { RunName } from "@/components/RunName";
import { pairCount, type Tiers } from "@/features/ranking/order/order";
import { isReadByStatements } from "@/features/ranking/understanding/use-understanding";
import { continuing, withSearch } from "@/lib/runs";

import styles from "./Hints.module.css";

/** Ranked and perfect games that are usually enough: docs/decisions/06-best-efforts.md. */
const GOOD_NUMBER = 4;
const GOOD_NUMBER_PERFECT = 3;
/** Ranked games whose order is told from shuffled ones: docs/decisions/26-statements.md. */
const GOOD_NUMBER_FOR_STATEMENTS = 10;

interface Hint {
  readonly id: string;
  readonly done: boolean;
  readonly text: string;
  /** Whether a run can be started without it. */
  readonly optional?: true;
}

/** Returns what training needs and whether it is there. */
function hintsFor(
  tiers: Tiers,
  nPerfect: number,
  borrowed: readonly LibraryEntry[],
  behaviour: Behaviour,
): readonly Hint[] {
  const ranked = new Set(tiers.flat());
  const nRanked = ranked.size;
  const nBorrowed = borrowed.filter(({ id }) => ranked.has(id)).length;
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
          text: t`Make at least two tiers: ties alone teach nothing.`,
        },
    nPerfect >= GOOD_NUMBER_PERFECT
      ? { id: "perfect", done: true, text: t`${nPerfect} marked as perfect` }
      : {
          id: "perfect",
          done: false,
          optional: true,
          text: [
            plural(nPerfect, {
              0: "No game has a star yet.",
              one: "# game has a star.",
              other: "# games have a star.",
            }),
            isReadByStatements(behaviour)
              ? t`Star at least three of your best games: the imitator begins by copying them.`
              : t`Star at least three of your best games: training learns most from what they hit.`,
          ].join(" "),
        },
    nRanked >= (isReadByStatements(behaviour) ? GOOD_NUMBER_FOR_STATEMENTS : GOOD_NUMBER)
      ? {
          id: "number",
          done: true,
          text: isReadByStatements(behaviour)
            ? t`${rankedText(nRanked, nBorrowed)}: enough once “What Tril understood” says what you mean.`
            : t`${rankedText(nRanked, nBorrowed)}: enough once “What this order asks for” shows what you mean.`,
        }
      : {
          id: "number",
          done: false,
          optional: true,
          text: isReadByStatements(behaviour)
            ? t`${rankedText(nRanked, nBorrowed)}. Ten, from good to hopeless, usually tell what you mean.`
            : t`${rankedText(nRanked, nBorrowed)}. Four, from good to hopeless, are usually enough.`,
        },
  ];
}

/** Counts the ranked games, and says how many of them are no recordings of the behaviour. */
function rankedText(n: number, nBorrowed: number): string {
  const games = plural(n, { one: "# game ranked", other: "# games ranked" });
  return nBorrowed > 0 ? t`${games}, ${nBorrowed} of them borrowed` : games;
}

/** Whether a run can be started. */
function canTrain(hints: readonly Hint[]): boolean {
  return hints.every(({ done, optional }) => done || optional);
}

/** What training needs, and the link to it once that is there. */
export function Hints({
  tiers,
  nPerfect,
  borrowed,
  behaviour,
}: {
  tiers: Tiers;
  nPerfect: number;
  /** What the behaviour has borrowed. */
  borrowed: readonly LibraryEntry[];
  behaviour: Behaviour;
}) {
  const at = `/behaviours/${behaviour.id}`;
  const further = continuing(useSearchParams()[0]);
  const parentId = further.get("continue");
  const hints = hintsFor(tiers, nPerfect, borrowed, behaviour);
  const isReady = canTrain(hints);
  return (
    <section className={styles.needs} aria-label={t`What training needs`}>
      <details className={styles.folded} open={!isReady || undefined}>
        <summary>
          <Icon name={hints.every(({ done }) => done) ? "check" : "alert"} />
          <Trans>What training needs</Trans>
        </summary>
        <ul className={styles.hints}>
          {hints.map((hint) => (
            <li key={hint.id} className={hint.done ? styles.ok : styles.open}>
              <Icon name={hint.done ? "check" : "alert"} />
              <span>{hint.text}</span>
            </li>
          ))}
        </ul>
      </details>
      {parentId !== null && (
        <p className={styles.next}>
          <Trans>
            The next run continues <RunName id={parentId} />.
          </Trans>
        </p>
      )}
      {isReady ? (
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
