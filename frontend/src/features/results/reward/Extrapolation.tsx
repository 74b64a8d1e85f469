import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { JudgedGames } from "@/api/types";
import { ActorMark } from "@/components/game/ActorMark";
import tables from "@/features/results/tables.module.css";
import { fixed, NONE, whole } from "@/lib/format";

import { marksOf, predictedOf, worthOf } from "./judged-games";
import { type Measure, nameOf, write } from "./measure";
import styles from "./reward.module.css";
import { ScatterPlot } from "./ScatterPlot";
import { wholeTicks } from "./ticks";

/** What the reward predicts against what games were worth: increasing if the reward is right. */
export function Extrapolation({ judged }: { judged: readonly JudgedGames[] }) {
  const all = worthOf(judged);
  const shown = worthOf(judged.filter((group) => group.demonstrated));
  const measure = judged[0]?.measure;
  if (!all || !measure) return null;
  const range = [all.low - 1, all.high + 1] as const;
  return (
    <>
      <p className={styles.verdict}>
        <Trans>
          A game is worth its targets minus its strays. The reward learned from the filled marks and
          has never seen the hollow ones, the games of imitator and clone. If it is right, the marks
          rise from left to right.
        </Trans>
        {shown && (
          <>
            {" "}
            <Trans>
              Beyond the shaded range of the recordings it can only guess (extrapolate).
            </Trans>
          </>
        )}
      </p>
      <div className={styles.check}>
        <Groups judged={judged} measure={measure} />
        <figure className={styles.scatter}>
          <figcaption>{t`${nameOf(measure)} by targets hit, less strays`}</figcaption>
          <ScatterPlot
            label={t`${nameOf(measure)} by targets hit, less strays; see the table for the numbers`}
            measure={measure}
            range={range}
            xTicks={wholeTicks(all.low, all.high, 12)}
            band={shown ? [shown.low - 0.5, shown.high + 0.5] : undefined}
            points={marksOf(judged)}
          />
        </figure>
      </div>
    </>
  );
}

/** The plot as a table. */
function Groups({ judged, measure }: { judged: readonly JudgedGames[]; measure: Measure }) {
  return (
    <table className={tables.table} aria-label={t`Predicted and actual worth of games`}>
      <thead>
        <tr>
          <th scope="col">
            <Trans>Games of</Trans>
          </th>
          <th scope="col" className={tables.number}>
            <Trans>Games</Trans>
          </th>
          <th scope="col" className={tables.number}>
            <Trans>Worth</Trans>
          </th>
          <th scope="col" className={tables.number}>
            {nameOf(measure)}
          </th>
          <th scope="col" className={tables.right}>
            <Trans>Agreement (Kendall&rsquo;s tau)</Trans>
          </th>
        </tr>
      </thead>
      <tbody>
        {judged.map((group) => (
          <tr key={`${group.player}-${String(group.demonstrated)}`}>
            <th scope="row">
              <ActorMark actor={group.player} hollow={!group.demonstrated} />
              <small>{group.demonstrated ? t`learned from` : t`never seen`}</small>
            </th>
            <td className={tables.number}>{group.games.length}</td>
            <td className={tables.number}>{between(worthOf([group]), whole)}</td>
            <td className={tables.number}>
              {between(predictedOf([group]), (value) => write(measure, value))}
            </td>
            <td className={tables.right}>{group.tau === null ? NONE : fixed(group.tau, 2)}</td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

function between(
  bounds: { low: number; high: number } | null,
  write: (value: number) => string,
): string {
  if (!bounds) return NONE;
  const { low, high } = bounds;
  return low === high ? write(low) : t`${write(low)} to ${write(high)}`;
}
