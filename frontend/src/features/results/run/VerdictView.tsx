import { t } from "@lingui/core/macro";

import type { Behaviour, Run, Verdict } from "@/api/types";
import { ButtonLink } from "@/components/controls/Button";
import { classes } from "@/lib/classes";

import styles from "./VerdictView.module.css";

interface VerdictViewProps {
  verdict: Verdict;
  run: Run;
  behaviour: Behaviour;
  /** Whether the page has games to rank. */
  canTeach: boolean;
}

/** What came of a run, in plain words, and what to do next. */
export function VerdictView({ verdict, run, behaviour, canTeach }: VerdictViewProps) {
  const next = nextOf(verdict.next_step, run, behaviour, canTeach);
  return (
    <section className={classes(styles.verdict, styles[verdict.tone])} aria-label={t`Verdict`}>
      <p className={styles.sentence}>{verdict.sentence}</p>
      <p className={styles.advice}>
        <span>{verdict.advice}</span>
        {next && (
          <ButtonLink kind="primary" to={next.to}>
            {next.label}
          </ButtonLink>
        )}
      </p>
    </section>
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
