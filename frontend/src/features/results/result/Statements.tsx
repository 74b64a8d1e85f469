import { t } from "@lingui/core/macro";
import { Plural, Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { useId, useRef } from "react";
import { Link } from "react-router";

import type { RankingCheck, Run, StatementAnswer } from "@/api/types";
import { ButtonLink } from "@/components/controls/Button";
import { StatementList } from "@/components/statements/StatementList";
import { isAbout, shownOf } from "@/components/statements/statements";
import { answersQuery, useAnswering } from "@/components/statements/use-answering";
import { againPath } from "@/features/results/run/again";

import styles from "./Statements.module.css";

interface StatementsProps {
  run: Run;
  check: RankingCheck;
}

/** What Tril says that the order is about, the most probable first, and whether it was meant. */
export function Statements({ run, check: { statements, answers: known } }: StatementsProps) {
  const titleId = useId();
  const title = useRef<HTMLHeadingElement>(null);
  const { data: answers = known } = useQuery(answersQuery(run.behaviour_id));
  const answering = useAnswering(run.behaviour_id);
  // Runs of earlier versions do not know what their statements are about.
  const isAnswerable = statements.every(({ subjects }) => subjects.length > 0);
  const shown = shownOf(statements);
  const told = known.filter((one) => !isAnswerable || !shown.some((of) => isAbout(one, of)));
  return (
    <section className={styles.statements} aria-labelledby={titleId}>
      <h3 id={titleId} ref={title} tabIndex={-1}>
        <Trans>What Tril understood: better games have</Trans>
      </h3>
      <StatementList
        behaviourId={run.behaviour_id}
        statements={shown}
        answers={isAnswerable ? answers : []}
        answering={isAnswerable ? answering : null}
        onGone={() => title.current?.focus()}
      />
      {told.length > 0 && (
        <ul aria-label={t`What you had told Tril`}>
          {told.map(({ sentence, meant }) => (
            <li key={sentence} className={styles.told}>
              {meant ? (
                <Trans>You said that this is it: {sentence}</Trans>
              ) : (
                <Trans>You said that it is not this: {sentence}</Trans>
              )}
            </li>
          ))}
        </ul>
      )}
      {isAnswerable ? (
        <Again run={run} known={known} answers={answers} />
      ) : (
        <p>
          <Trans>
            Is this what you meant?{" "}
            <Link to={`/behaviours/${run.behaviour_id}/rank`}>Answer under Rank</Link>; it counts in
            the next run.
          </Trans>
        </p>
      )}
      <p role="status" className="visually-hidden">
        {answering.spoken}
      </p>
    </section>
  );
}

interface AgainProps {
  run: Run;
  /** What the run was told. */
  known: readonly StatementAnswer[];
  answers: readonly StatementAnswer[];
}

/** Asks whether it was meant, or offers to train again with what the run was not told. */
function Again({ run, known, answers }: AgainProps) {
  const added = without(answers, known);
  if (added.length === 0 && without(known, answers).length === 0)
    return (
      <p>
        <Trans>Is this what you meant? Your answer counts in the next run.</Trans>
      </p>
    );
  return (
    <div>
      <ButtonLink kind="primary" icon="redo" to={againPath(run)}>
        {added.length === 0 ? (
          <Trans>Train again without it</Trans>
        ) : (
          <Plural
            value={added.length}
            one="Train again with this answer"
            other="Train again with these answers"
          />
        )}
      </ButtonLink>
    </div>
  );
}

/** Returns the answers that are not among others. */
function without(
  answers: readonly StatementAnswer[],
  others: readonly StatementAnswer[],
): readonly StatementAnswer[] {
  return answers.filter(
    (one) => !others.some((other) => isAbout(other, one) && other.meant === one.meant),
  );
}
