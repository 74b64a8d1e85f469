import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { type RefObject, useImperativeHandle, useRef } from "react";

import { actionName, actionsInOrder } from "@/games/actions";
import { useGame } from "@/games/game";
import { fixed, NONE, percent, withDeviation } from "@/lib/format";

import styles from "./DecisionBars.module.css";
import type { Decision } from "./watch-messages";

/** Updates the bars without rendering: they change 15 times a second. */
export interface DecisionHandle {
  decide: (decision: Decision) => void;
  reward: (level: number, deviation: number | null) => void;
}

/** How likely the policy finds each action of the next step, and what the reward model says. */
export function DecisionBars({ handle }: { handle: RefObject<DecisionHandle | null> }) {
  const game = useGame();
  const actions = actionsInOrder(game);
  const list = useRef<HTMLOListElement>(null);
  const figure = useRef<HTMLElement>(null);
  useImperativeHandle(handle, () => ({
    decide: ({ action, probabilities }) => {
      for (const [at, row] of [...(list.current?.children ?? [])].entries()) {
        const share = probabilities[actions[at] ?? 0] ?? 0;
        row.toggleAttribute("data-chosen", actions[at] === action);
        row.querySelector("i")?.style.setProperty("transform", `scaleX(${share})`);
        const text = row.querySelector("output");
        if (text) text.textContent = percent(share, 0);
      }
    },
    reward: (level, deviation) => {
      if (figure.current) figure.current.textContent = withDeviation(fixed(level, 2), deviation);
    },
  }));
  return (
    <div className={styles.decisions}>
      <ol ref={list} aria-label={t`Probability of each action of the next step`}>
        {actions.map((action) => (
          <li key={action}>
            <span>{actionName(action, game)}</span>
            <span className={styles.bar}>
              <i />
            </span>
            <output aria-live="off">{NONE}</output>
          </li>
        ))}
      </ol>
      <p
        title={t`The learned reward R of what is on the screen now, ± its standard deviation: 0 is nothing reached, 1 as in the best games. Imitator and clone do not see it.`}
      >
        <Trans>
          Reward R <b ref={figure}>{NONE}</b>
        </Trans>
      </p>
    </div>
  );
}
