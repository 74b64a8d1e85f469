import { type RefObject, useImperativeHandle, useRef } from "react";

import { fixed, NONE, percent, withDeviation } from "@/lib/format";

import styles from "./DecisionBars.module.css";
import type { Decision } from "./watch-messages";

/** Updates the bars without rendering: they change 15 times a second. */
export interface DecisionHandle {
  decide: (decision: Decision) => void;
  reward: (reward: number, deviation: number | null) => void;
}

/** The actions from left to right, by their number. */
const ACTIONS = [
  { action: 3, name: "left" },
  { action: 5, name: "left, fire" },
  { action: 0, name: "wait" },
  { action: 1, name: "fire" },
  { action: 2, name: "right" },
  { action: 4, name: "right, fire" },
] as const;

/** How likely the policy finds each action of the next step, and what the reward model says. */
export function DecisionBars({ handle }: { handle: RefObject<DecisionHandle | null> }) {
  const list = useRef<HTMLOListElement>(null);
  const figure = useRef<HTMLElement>(null);
  useImperativeHandle(handle, () => ({
    decide: ({ action, probabilities }) => {
      for (const [at, row] of [...(list.current?.children ?? [])].entries()) {
        const share = probabilities[ACTIONS[at]?.action ?? 0] ?? 0;
        row.toggleAttribute("data-chosen", ACTIONS[at]?.action === action);
        row.querySelector("i")?.style.setProperty("transform", `scaleX(${share})`);
        const text = row.querySelector("output");
        if (text) text.textContent = percent(share, 0);
      }
    },
    reward: (reward, deviation) => {
      if (figure.current) figure.current.textContent = withDeviation(fixed(reward, 2), deviation);
    },
  }));
  return (
    <div className={styles.decisions}>
      <ol ref={list} aria-label="Probability of each action of the next step">
        {ACTIONS.map(({ action, name }) => (
          <li key={action}>
            <span>{name}</span>
            <span className={styles.bar}>
              <i />
            </span>
            <output aria-live="off">{NONE}</output>
          </li>
        ))}
      </ol>
      <p title="The learned reward R of what is on the screen now, ± its standard deviation. The policy does not see it.">
        Reward R <b ref={figure}>{NONE}</b>
      </p>
    </div>
  );
}
