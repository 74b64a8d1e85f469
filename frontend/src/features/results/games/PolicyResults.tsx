import type { Behaviour, PolicyGamesSummary, PolicySummary, RunResults } from "@/api/types";
import { count } from "@/lib/format";

import styles from "./PolicyResults.module.css";
import { SummaryTable } from "./SummaryTable";

type ActionSelection = PolicyGamesSummary["action_selection"];

/** Besides greedy, which is shown first; runs of earlier versions have no sticky games. */
const OTHER_SELECTIONS = [
  {
    selection: "sampled",
    title: "With sampled actions",
    note: "Each policy samples its actions from its distribution.",
    label: "Imitator and clone, with sampled actions",
  },
  {
    selection: "sticky",
    title: "With sticky actions",
    note:
      "Each policy takes its most probable action, but at every frame the last frame’s action is " +
      "repeated with a probability of 25%: a test of whether it recovers.",
    label: "Imitator and clone, with sticky actions",
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
      <SummaryTable {...greedy} behaviour={behaviour} label="Imitator and clone" />
      <p className={styles.note}>
        Means of {count(n, "game")} from starts that no training or demonstration game began from,
        with 95 % bootstrap intervals. Each policy takes its most probable action.
      </p>
      {OTHER_SELECTIONS.map(({ selection, title, note, label }) => {
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
