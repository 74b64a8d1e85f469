import { t } from "@lingui/core/macro";

import type { Behaviour, RunResults } from "@/api/types";
import { ActorMark } from "@/components/game/ActorMark";
import { IntervalPlot } from "@/features/results/games/IntervalPlot";
import { useGame } from "@/games/game";
import { actorNames } from "@/lib/actors";

import { figuresOf } from "./figures";
import styles from "./Figures.module.css";

/** At most five figures, each with its picture. */
export function Figures({ results, behaviour }: { results: RunResults; behaviour: Behaviour }) {
  const figures = figuresOf(results, behaviour, useGame());
  if (figures.length === 0) return null;
  return (
    <dl className={styles.figures} aria-label={t`Figures`}>
      {figures.map(({ name, value, others, plot }) => (
        <div key={name}>
          <dt>{name}</dt>
          <dd className={styles.value}>{value}</dd>
          <dd className={styles.others}>
            {others.map(({ actor, text }) => (
              <ActorMark key={actor} actor={actor}>
                {actorNames()[actor]} {text}
              </ActorMark>
            ))}
            {plot && (
              <IntervalPlot
                low={plot.low}
                high={plot.high}
                intervals={[
                  { actor: "imitator", interval: plot.interval },
                  ...others.flatMap(({ actor, interval }) =>
                    interval ? [{ actor, interval }] : [],
                  ),
                ]}
              />
            )}
          </dd>
        </div>
      ))}
    </dl>
  );
}
