import type { Behaviour, PolicyGamesSummary, PolicySummary, RunResults } from "@/api/types";
import { count } from "@/lib/format";

import styles from "./PolicyResults.module.css";
import { SummaryTable } from "./SummaryTable";

type ActionSelection = PolicyGamesSummary["action_selection"];

/** Beside greedy, the headline's; runs of earlier versions have no sticky games. */
const OTHER_SELECTIONS = [
  {
    selection: "sampled",
    title: "With actions drawn by chance instead",
    note: "Each policy draws its action by the probabilities that it gives them.",
    label: "Imitator and clone, actions drawn by chance",
  },
  {
    selection: "sticky",
    title: "With sticky actions",
    note:
      "Each policy takes the action it thinks best, but at every frame there is a chance of 25 % " +
      "that the last frame’s action is executed again: a test of whether it can recover.",
    label: "Imitator and clone, with sticky actions",
  },
] as const;

/** What imitator and clone achieved, by action selection. */
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
        with 95 % bootstrap intervals. Each policy takes the action it thinks best.
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
