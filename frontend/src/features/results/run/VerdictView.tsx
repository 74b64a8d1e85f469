import { t } from "@lingui/core/macro";

import type { Behaviour, Run, RunResults, Verdict } from "@/api/types";
import { ButtonLink } from "@/components/controls/Button";
import { classes } from "@/lib/classes";

import styles from "./VerdictView.module.css";

interface VerdictViewProps {
  verdict: Verdict;
  run: Run;
  results: RunResults;
  behaviour: Behaviour;
}

/** What came of a run, in plain words, and what to do next. */
export function VerdictView(props: VerdictViewProps) {
  return (
    <section className={classes(styles.verdict, toneOf(props.verdict))} aria-label={t`Verdict`}>
      <VerdictSentence verdict={props.verdict} />
      <VerdictDetails verdict={props.verdict} />
      <NextStep {...props} />
    </section>
  );
}

/** Returns the class that gives an element the colour of a verdict, as `--tone`. */
export function toneOf({ tone }: Verdict): string | undefined {
  return styles[tone];
}

/** The result in one sentence. */
export function VerdictSentence({ verdict: { sentence } }: { verdict: Verdict }) {
  return <p className={styles.sentence}>{sentence}</p>;
}

/** The figures behind the sentence. */
export function VerdictDetails({ verdict: { details } }: { verdict: Verdict }) {
  return details && <p className={styles.details}>{details}</p>;
}

/** What to do next, and where. */
export function NextStep({ verdict, run, results, behaviour }: VerdictViewProps) {
  // Whether the page has games to rank.
  const canTeach = results.proposed.length > 0 || results.training_games !== null;
  const next = nextOf(verdict.next_step, run, behaviour, canTeach);
  return (
    <p className={styles.advice}>
      <span>{verdict.advice}</span>
      {next && (
        <ButtonLink kind="primary" to={next.to}>
          {next.label}
        </ButtonLink>
      )}
    </p>
  );
}

function nextOf(
  step: Verdict["next_step"],
  run: Run,
  behaviour: Behaviour,
  canTeach: boolean,
): { to: string; label: string } | null {
  const at = `/behaviours/${behaviour.id}`;
  switch (step) {
    case "games":
      return { to: `/runs/${run.id}#games`, label: t`Go to its games` };
    case "teach":
      return canTeach
        ? { to: `/runs/${run.id}#teach`, label: t`Choose games to rank` }
        : { to: `${at}/rank`, label: t`Go to the ranking` };
    case "rank":
      return { to: `${at}/rank`, label: t`Go to the ranking` };
    case "train":
      return { to: `${at}/train`, label: t`Train again` };
    case null:
      return null;
  }
}
