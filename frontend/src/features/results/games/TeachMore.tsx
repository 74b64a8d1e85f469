import { t } from "@lingui/core/macro";
import { Plural, Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { useNavigate } from "react-router";

import { borrowedQuery } from "@/api/library";
import type { Behaviour, Recording, RunResults, TaughtGame } from "@/api/types";
import { Button, ButtonLink } from "@/components/controls/Button";
import { ItemGrid } from "@/components/game/ItemGrid";
import { FilmStrip, LOOPS } from "@/components/recording/GamePicture";
import { useBorrowing } from "@/components/recording/use-borrowing";
import type { Watched } from "@/features/results/watched";
import { useGame } from "@/games/game";
import { describeEnd, describeResult, imperfections, isLost } from "@/games/outcomes";
import { whole } from "@/lib/format";
import { takenCells } from "@/lib/game/items";
import { isActive } from "@/lib/runs";
import { selecting } from "@/lib/selection";

import { AddToRanking } from "./AddToRanking";
import styles from "./TeachMore.module.css";

interface TeachMoreProps {
  results: RunResults;
  behaviour: Behaviour;
  onWatch: (watched: Watched) => void;
}

interface Proposal {
  readonly recording: Recording;
  /** How it was played, in words. */
  readonly how: string;
}

/** Returns evaluation games of the imitator, or those of its training while there are none. */
function proposalsIn({ proposed, games, training_games: training }: RunResults): Proposal[] {
  const evaluated = proposed.flatMap((id) => {
    const game = games.find(({ recording }) => recording.id === id);
    if (!game) return [];
    const start = game.start_number;
    const how = {
      greedy: t`greedy actions, start ${start}`,
      sampled: t`sampled actions, start ${start}`,
      sticky: t`sticky actions, start ${start}`,
    }[game.action_selection];
    return [{ recording: game.recording, how }];
  });
  if (evaluated.length > 0 || !training) return evaluated;
  const how = t`after ${whole(training.steps)} steps`;
  return training.games.map((recording) => ({ recording, how }));
}

/** Whether a game hits all targets and nothing else, and survives; never without a target. */
function isFlawless({ recording }: Proposal, behaviour: Behaviour, game: TaughtGame): boolean {
  return (
    behaviour.target !== null &&
    recording.targets !== null &&
    !isLost(recording.end, game) &&
    imperfections(recording, behaviour, game).length === 0
  );
}

function advice(areFlawless: boolean, active: boolean): string {
  if (areFlawless)
    return t`These games of the imitator are flawless, so ranking them teaches it little.`;
  return active
    ? t`These games of the imitator differ most. Rank them among yours and continue: the reward is learned again, and the imitator trains on from where it is.`
    : t`These games of the imitator differ most. Rank them among yours and train again: the reward learns what it missed.`;
}

/** Proposes games of the imitator for the ranking, and to train the imitator further. */
export function TeachMore({ results, behaviour, onWatch }: TeachMoreProps) {
  const game = useGame();
  const games = proposalsIn(results);
  const active = isActive(results.run);
  const further = (
    <ButtonLink to={`/behaviours/${behaviour.id}/train?${furtherFrom(results, active).toString()}`}>
      {active ? t`Go on with the new order` : t`Train further from this imitator`}
    </ButtonLink>
  );
  if (games.length === 0) return <div className={styles.buttons}>{further}</div>;
  return (
    <>
      <p className={styles.note}>
        {advice(
          games.every((one) => isFlawless(one, behaviour, game)),
          active,
        )}
      </p>
      <ul className={styles.games} aria-label={t`Games to rank`}>
        {games.map((proposal) => (
          <ProposedGame
            key={proposal.recording.id}
            proposal={proposal}
            behaviour={behaviour}
            onWatch={onWatch}
          />
        ))}
      </ul>
      <div className={styles.buttons}>
        <AddAll games={games} behaviourId={behaviour.id} further={furtherFrom(results, active)} />
        {further}
      </div>
    </>
  );
}

/** Returns what an address says of a run that continues this one: with the steps that are left. */
function furtherFrom(
  { run, training_games: training }: RunResults,
  active: boolean,
): URLSearchParams {
  const search = new URLSearchParams({ continue: run.id });
  const left = run.steps - (training?.steps ?? 0);
  if (active && left > 0) search.set("steps", String(left));
  return search;
}

function ProposedGame({
  proposal: { recording, how },
  behaviour,
  onWatch,
}: {
  proposal: Proposal;
  behaviour: Behaviour;
  onWatch: (watched: Watched) => void;
}) {
  const game = useGame();
  const result = describeResult(recording, behaviour, game);
  return (
    <li className={styles.game} {...LOOPS}>
      <button
        type="button"
        className={styles.watch}
        aria-label={t`Watch imitator, ${how}`}
        onClick={() => onWatch({ recording, title: t`Imitator, ${how}` })}
      >
        <FilmStrip recording={recording} />
      </button>
      <div className={styles.outcome}>
        <ItemGrid hits={takenCells(recording)} target={behaviour.target} label="" />
        <p>
          {result && <b>{result}</b>}
          <span>{describeEnd(recording.end, game)}</span>
          <span>{how}</span>
        </p>
      </div>
      <AddToRanking recording={recording} behaviourId={behaviour.id} />
    </li>
  );
}

/**
 * Adds all games to the unranked ones and leads there, or to placing those that are. The rank page
 * leads on to a run that continues this one.
 */
function AddAll({
  games,
  behaviourId,
  further,
}: {
  games: readonly Proposal[];
  behaviourId: number;
  further: URLSearchParams;
}) {
  const { data: borrowed } = useQuery(borrowedQuery(behaviourId));
  const { add, isPending } = useBorrowing(behaviourId);
  const navigate = useNavigate();
  const rank = `/behaviours/${behaviourId}/rank?${further.toString()}`;
  const held = new Map(borrowed?.map(({ id, ranked }) => [id, ranked]));
  const ids = games.map(({ recording }) => recording.id);
  const missing = ids.filter((id) => !held.has(id));
  return (
    <>
      {missing.length === 0 ? (
        <ButtonLink kind="primary" to={rank}>
          <Trans>Rank them</Trans>
        </ButtonLink>
      ) : (
        <Button
          kind="primary"
          icon="plus"
          disabled={isPending}
          onClick={() =>
            void add(missing).then(
              (added) => added && navigate(rank, { state: selecting(missing) }),
            )
          }
        >
          <Plural
            value={missing.length}
            one="Add # game and rank it"
            other="Add # games and rank them"
          />
        </Button>
      )}
      {ids.some((id) => held.get(id) === false) && (
        <ButtonLink kind="quiet" icon="compare" to={`${rank}&compare`}>
          <Trans>Place by comparing</Trans>
        </ButtonLink>
      )}
    </>
  );
}
