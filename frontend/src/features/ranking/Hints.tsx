import { Link } from "react-router";

import type { Behaviour, Recording } from "@/api/types";
import { ButtonLink } from "@/components/controls/Button";
import { Icon } from "@/components/controls/Icon";
import { pairCount, type Tiers } from "@/features/ranking/order/order";
import { count } from "@/lib/format";

import styles from "./Hints.module.css";

const GOOD_NUMBER = 12;

interface Hint {
  readonly id: string;
  readonly done: boolean;
  readonly text: string;
}

/** Returns what training needs and whether it is there. */
function hintsFor(tiers: Tiers, recordings: readonly Recording[]): readonly Hint[] {
  const nRanked = tiers.flat().length;
  const nPerfect = recordings.filter((one) => one.perfect).length;
  const pairs = pairCount(tiers);
  return [
    tiers.length >= 2
      ? { id: "tiers", done: true, text: `${count(pairs, "preference pair")} to learn from` }
      : {
          id: "tiers",
          done: false,
          text: "At least two tiers are needed: nothing can be learned from ties alone.",
        },
    nPerfect >= 1
      ? { id: "perfect", done: true, text: `${nPerfect} marked as perfect` }
      : {
          id: "perfect",
          done: false,
          text: "No recording is marked as perfect. The clone copies those: mark one with its star.",
        },
    nRanked >= GOOD_NUMBER
      ? { id: "number", done: true, text: `${nRanked} recordings ranked` }
      : {
          id: "number",
          done: false,
          text: `${nRanked} ranked. About ${GOOD_NUMBER}, from perfect to hopeless, work well.`,
        },
  ];
}

/** Whether a run can be started. */
function canTrain(tiers: Tiers, recordings: readonly Recording[]): boolean {
  return hintsFor(tiers, recordings).every((hint) => hint.done || hint.id === "number");
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
  return (
    <section className={styles.hints} aria-label="What training needs">
      <ul className={styles.hints}>
        {hintsFor(tiers, recordings).map((hint) => (
          <li key={hint.id} className={hint.done ? styles.ok : styles.open}>
            <Icon name={hint.done ? "check" : "alert"} />
            <span>{hint.text}</span>
          </li>
        ))}
      </ul>
      {canTrain(tiers, recordings) ? (
        <ButtonLink kind="primary" to={`${at}/train`}>
          Continue to Train
        </ButtonLink>
      ) : (
        <Link to={`${at}/play`}>Play more games</Link>
      )}
    </section>
  );
}
