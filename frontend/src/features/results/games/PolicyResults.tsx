import { t } from "@lingui/core/macro";
import { Plural, Trans } from "@lingui/react/macro";

import type { Behaviour, PolicyGamesSummary, PolicySummary, RunResults } from "@/api/types";

import { MeasureTable } from "./MeasureTable";
import styles from "./PolicyResults.module.css";
import { SummaryTable } from "./SummaryTable";

type ActionSelection = PolicyGamesSummary["action_selection"];

/** Besides greedy, which is shown first; runs of earlier versions have no sticky games. */
const otherSelections = () =>
  [
    {
      selection: "sampled",
      title: t`With sampled actions`,
      note: t`Imitator and clone sample their actions from their distributions.`,
      label: t`Imitator and clone, with sampled actions`,
    },
    {
      selection: "sticky",
      title: t`With sticky actions`,
      note: t`At every frame, the last action is repeated with probability 25%: a test of whether they recover.`,
      label: t`Imitator and clone, with sticky actions`,
    },
  ] as const;

/** The results of imitator and clone, by action selection. */
export function PolicyResults({
  results,
  behaviour,
}: {
  results: RunResults;
  behaviour: Behaviour;
}) {
  const find = (policy: "imitator" | "clone", selection: ActionSelection): PolicySummary | null =>
    results.summaries.find((one) => one.policy === policy && one.action_selection === selection)
      ?.summary ?? null;
  const both = (selection: ActionSelection) => ({
    imitator: find("imitator", selection),
    clone: find("clone", selection),
  });
  const greedy = both("greedy");
  const n = greedy.imitator?.steps.n ?? greedy.clone?.steps.n ?? 0;
  return (
    <>
      <SummaryTable {...greedy} behaviour={behaviour} label={t`Imitator and clone`} />
      <p className={styles.note}>
        <Trans>
          Means of <Plural value={n} one="# game" other="# games" /> from starts that training never
          used, with 95% bootstrap intervals. The predicted return is the learned reward of a whole
          game.
        </Trans>
      </p>
      <MeasureTable rows={results.measures} />
      {otherSelections().map(({ selection, title, note, label }) => {
        const found = both(selection);
        return (
          (found.imitator ?? found.clone) && (
            <details key={selection} className={styles.selection}>
              <summary className={styles.note}>{title}</summary>
              <p className={styles.note}>{note}</p>
              <SummaryTable {...found} behaviour={behaviour} label={label} />
            </details>
          )
        );
      })}
    </>
  );
}
