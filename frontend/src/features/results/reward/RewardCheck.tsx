import type { Behaviour, ConfusedTiers, RankingCheck } from "@/api/types";
import { SourceBadge } from "@/components/recording/SourceBadge";
import tables from "@/features/results/tables.module.css";
import type { Watched } from "@/features/results/watched";
import { count, fixed, measured, percent } from "@/lib/format";
import { recordingName, describeScore } from "@/lib/recordings";

import { ReturnsByTier } from "./ReturnsByTier";
import styles from "./reward.module.css";

interface RewardCheckProps {
  check: RankingCheck;
  behaviour: Behaviour;
  onWatch: (watched: Watched) => void;
}

/** How well the learned reward agrees with the ranking. */
export function RewardCheck({ check, behaviour, onWatch }: RewardCheckProps) {
  return (
    <>
      <Numbers check={check} />
      <p className={styles.verdict}>{verdictOf(check)}</p>
      {check.confused.length > 0 && <Confused confused={check.confused} />}
      <div className={styles.check}>
        <Returns check={check} behaviour={behaviour} onWatch={onWatch} />
        <ReturnsByTier returns={check.returns} />
      </div>
    </>
  );
}

function verdictOf({ passed, advice, warning }: RankingCheck): string {
  if (!passed) return advice;
  const order = "The learned reward orders the recordings as they are ranked";
  return warning ? `${order}, but can’t tell some tiers apart.` : `${order}.`;
}

function Numbers({ check }: { check: RankingCheck }) {
  return (
    <dl className={styles.numbers}>
      <div>
        <dt>Kendall&rsquo;s tau</dt>
        <dd>{fixed(check.tau, 2)}</dd>
      </div>
      <div>
        <dt>Fragment pairs in order</dt>
        <dd>{percent(check.pair_accuracy)}</dd>
      </div>
      {check.held_out_accuracy !== null && (
        <div>
          <dt>Held-out pairs in order</dt>
          <dd>{percent(check.held_out_accuracy)}</dd>
        </div>
      )}
    </dl>
  );
}

/** The rest is collapsed. */
const SHOWN = 6;

function Confused({ confused }: { confused: RankingCheck["confused"] }) {
  const sorted = [...confused].sort((a, b) => Number(a.held_out) - Number(b.held_out));
  const more = sorted.slice(SHOWN);
  return (
    <section aria-label="Confused tiers" className={styles.confused}>
      <h3>Confused tiers</h3>
      <ConfusedList confused={sorted.slice(0, SHOWN)} />
      {more.length > 0 && (
        <details>
          <summary>{more.length} more</summary>
          <ConfusedList confused={more} />
        </details>
      )}
    </section>
  );
}

function ConfusedList({ confused }: { confused: RankingCheck["confused"] }) {
  return (
    <ul>
      {confused.map((one) => (
        <li key={`${one.better_tier}-${one.worse_tier}-${String(one.held_out)}`}>
          Tier {one.better_tier} ({names(one.better)}) isn&rsquo;t always ranked above the worse
          tier {one.worse_tier} ({names(one.worse)})
          {one.held_out ? " when one of their recordings is held out" : ""}
          {counted(one)}.
        </li>
      ))}
    </ul>
  );
}

/** Empty for runs of earlier versions, which did not count. */
function counted({ n_right: right, n_compared: all }: ConfusedTiers): string {
  return right === null || all === null ? "" : `: ${right} of ${count(all, "comparison")} in order`;
}

function names(ids: readonly number[]): string {
  return ids.map((id) => recordingName({ id })).join(", ");
}

function Returns({ check, behaviour, onWatch }: RewardCheckProps) {
  const hasLevels = check.returns.some((one) => one.final_level !== null);
  const best = Math.max(...check.returns.map(judged));
  const odd = (index: number) =>
    isOdd(check, index) ? `${tables.right} ${styles.odd}` : tables.right;
  return (
    <table className={tables.table} aria-label="Predicted returns">
      <thead>
        <tr>
          <th scope="col">Tier</th>
          <th scope="col">Recording</th>
          <th scope="col">Played by</th>
          <th scope="col" className={tables.right}>
            Predicted return
          </th>
          {hasLevels && (
            <th
              scope="col"
              className={tables.right}
              title="What the game reached in the end: 0 at the beginning, 1 at the end of the best"
            >
              Final level
            </th>
          )}
        </tr>
      </thead>
      <tbody>
        {check.returns.map(({ tier, recording, predicted_return, final_level }, index) => (
          <tr key={recording.id}>
            <td>{tier}</td>
            <td>
              <button
                type="button"
                title={describeScore(recording, behaviour.target?.length ?? null)}
                onClick={() => onWatch({ recording, title: recordingName(recording) })}
              >
                {recordingName(recording)}
              </button>
            </td>
            <td>
              <SourceBadge recording={recording} />
            </td>
            <td className={hasLevels ? tables.right : odd(index)}>
              {measured(predicted_return)}
              {!hasLevels && predicted_return === best && tier > 1 && <Highest />}
            </td>
            {hasLevels && (
              <td className={odd(index)}>
                {final_level === null ? "" : fixed(final_level, 2)}
                {final_level === best && tier > 1 && <Highest />}
              </td>
            )}
          </tr>
        ))}
      </tbody>
    </table>
  );
}

function Highest() {
  return <span className="visually-hidden"> (highest)</span>;
}

/** What the ranking is checked by: the final level, or the return in runs of earlier versions. */
function judged(one: RankingCheck["returns"][number]): number {
  return one.final_level ?? one.predicted_return;
}

/** Whether a game is judged to be better than one of a better tier. */
function isOdd({ returns }: RankingCheck, index: number): boolean {
  const one = returns[index];
  if (!one) return false;
  return returns.some((other) => other.tier < one.tier && judged(other) < judged(one));
}
