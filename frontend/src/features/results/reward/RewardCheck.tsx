import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { Behaviour, ConfusedTiers, RankingCheck, Recording } from "@/api/types";
import { SourceBadge } from "@/components/recording/SourceBadge";
import tables from "@/features/results/tables.module.css";
import type { Watched } from "@/features/results/watched";
import { viewOf } from "@/games/views";
import { useGame } from "@/games/game";
import { describeResult } from "@/games/outcomes";
import { fixed, percent } from "@/lib/format";
import { recordingName } from "@/lib/recordings";

import { judgedBy, type Measure, measureOf, nameOf, type RankedReturn, write } from "./measure";
import styles from "./reward.module.css";
import { RewardByTier } from "./RewardByTier";

interface RewardCheckProps {
  check: RankingCheck;
  /** The run's message, which stands above. */
  message: string;
  behaviour: Behaviour;
  onWatch: (watched: Watched) => void;
}

/** How well the learned reward agrees with the ranking. */
export function RewardCheck({ check, message, behaviour, onWatch }: RewardCheckProps) {
  const verdict = verdictOf(check);
  const Wanted = viewOf(behaviour.game)?.Wanted;
  const measure = measureOf(check.returns);
  const isStatement = check.statements.length > 0;
  return (
    <>
      <Numbers check={check} />
      {verdict !== message && <p className={styles.verdict}>{verdict}</p>}
      {check.wanted && Wanted && (
        <Wanted
          title={t`What the reward wants`}
          inferred={check.wanted}
          behaviour={behaviour}
          scale={3}
        />
      )}
      {check.confused.length > 0 && <Confused check={check} />}
      {measure === "final_level" && (
        <p className={styles.verdict}>
          {isStatement ? (
            <Trans>
              What a game reaches in all: 0 is nothing, 1 a game of full length that is played
              throughout as well as the best ones.
            </Trans>
          ) : (
            <Trans>
              The final level is the reward at the end of a game: 0 is how games begin, 1 how the
              best ones end.
            </Trans>
          )}
        </p>
      )}
      <div className={styles.check}>
        <Returns check={check} behaviour={behaviour} measure={measure} onWatch={onWatch} />
        <RewardByTier
          returns={check.returns}
          measure={measure}
          name={nameOf(measure, isStatement)}
        />
      </div>
    </>
  );
}

function verdictOf({ passed, advice, confused }: RankingCheck): string {
  if (!passed) return advice;
  return confused.length > 0
    ? t`The learned reward agrees with most of the order. It differs here:`
    : t`The learned reward orders the recordings as they are ranked.`;
}

function Numbers({ check }: { check: RankingCheck }) {
  return (
    <dl className={styles.numbers}>
      <div>
        <dt>
          <Trans>Agreement with the ranking, 1 at most (Kendall&rsquo;s tau)</Trans>
        </dt>
        <dd>{fixed(check.tau, 2)}</dd>
      </div>
      <div>
        <dt>
          <Trans>Pairs of short pieces of games in order (fragments)</Trans>
        </dt>
        <dd>{percent(check.pair_accuracy)}</dd>
      </div>
      {check.held_out_accuracy !== null && (
        <div>
          <dt>
            <Trans>Pairs with an unseen game in order (held out)</Trans>
          </dt>
          <dd>{percent(check.held_out_accuracy)}</dd>
        </div>
      )}
    </dl>
  );
}

/** The rest is collapsed. */
const SHOWN = 6;

function Confused({ check }: { check: RankingCheck }) {
  const known = new Map(check.returns.map(({ recording }) => [recording.id, recording]));
  const sorted = [...check.confused].sort((a, b) => Number(a.held_out) - Number(b.held_out));
  const more = sorted.slice(SHOWN);
  return (
    <section aria-label={t`Confused tiers`} className={styles.confused}>
      <h3>
        <Trans>Confused tiers</Trans>
      </h3>
      <p>
        <Trans>
          If the difference matters, rank more games that show it; if it doesn&rsquo;t, merge the
          tiers.
        </Trans>
      </p>
      <ConfusedList confused={sorted.slice(0, SHOWN)} known={known} />
      {more.length > 0 && (
        <details>
          <summary>
            <Trans>{more.length} more</Trans>
          </summary>
          <ConfusedList confused={more} known={known} />
        </details>
      )}
    </section>
  );
}

type Known = ReadonlyMap<number, Recording>;

function ConfusedList({ confused, known }: { confused: RankingCheck["confused"]; known: Known }) {
  return (
    <ul>
      {confused.map((tiers) => (
        <li key={`${tiers.better_tier}-${tiers.worse_tier}-${String(tiers.held_out)}`}>
          {describeConfused(tiers, known)}
        </li>
      ))}
    </ul>
  );
}

/** Says which games the reward mixes up; runs of earlier versions did not count how often. */
function describeConfused(tiers: ConfusedTiers, known: Known): string {
  const { held_out: heldOut, n_right: right, n_compared: all } = tiers;
  const [above, below] = [names(tiers.better, known), names(tiers.worse, known)];
  if (right === null || all === null)
    return heldOut
      ? t`${above} above ${below}: the reward disagrees if one of them is held out.`
      : t`${above} above ${below}: the reward disagrees.`;
  return heldOut
    ? t`${above} above ${below}: right in ${right} of ${all} with one of them held out.`
    : t`${above} above ${below}: right in ${right} of ${all}.`;
}

function names(ids: readonly number[], known: Known): string {
  return ids.map((id) => recordingName(known.get(id))).join(", ");
}

function Returns({
  check,
  behaviour,
  measure,
  onWatch,
}: Omit<RewardCheckProps, "message"> & { measure: Measure }) {
  const game = useGame();
  const judged = (one: RankedReturn) => judgedBy(measure, one);
  const best = Math.max(...check.returns.map(judged));
  const odd = (index: number) =>
    isOdd(check.returns, judged, index) ? `${tables.right} ${styles.odd}` : tables.right;
  return (
    <table className={tables.table} aria-label={t`Ranked games by the reward`}>
      <thead>
        <tr>
          <th scope="col">
            <Trans>Tier</Trans>
          </th>
          <th scope="col">
            <Trans>Recording</Trans>
          </th>
          <th scope="col">
            <Trans>Played by</Trans>
          </th>
          <th scope="col" className={tables.right}>
            {nameOf(measure, check.statements.length > 0)}
          </th>
        </tr>
      </thead>
      <tbody>
        {check.returns.map((one, index) => (
          <tr key={one.recording.id}>
            <td>{one.tier}</td>
            <td>
              <button
                type="button"
                title={describeResult(one.recording, behaviour, game)}
                onClick={() =>
                  onWatch({ recording: one.recording, title: recordingName(one.recording) })
                }
              >
                {recordingName(one.recording)}
              </button>
            </td>
            <td>
              <SourceBadge recording={one.recording} />
            </td>
            <td className={odd(index)}>
              {write(measure, judged(one))}
              {judged(one) === best && one.tier > 1 && <Highest />}
            </td>
          </tr>
        ))}
      </tbody>
    </table>
  );
}

function Highest() {
  return (
    <span className="visually-hidden">
      {" "}
      (<Trans>highest</Trans>)
    </span>
  );
}

/** Whether a game is judged to be better than one of a better tier. */
function isOdd(
  returns: RankingCheck["returns"],
  judged: (one: RankedReturn) => number,
  index: number,
): boolean {
  const one = returns[index];
  if (!one) return false;
  return returns.some((other) => other.tier < one.tier && judged(other) < judged(one));
}
