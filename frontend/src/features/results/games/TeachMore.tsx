import { useQuery } from "@tanstack/react-query";
import { useNavigate } from "react-router";

import { borrowedQuery } from "@/api/borrowed";
import type { Behaviour, EvaluationGame, RunResults } from "@/api/types";
import { Button, ButtonLink } from "@/components/controls/Button";
import { AlienGrid } from "@/components/game/AlienGrid";
import { RecordingScreen } from "@/components/recording/RecordingScreen";
import { useBorrowing } from "@/components/recording/use-borrowing";
import type { Watched } from "@/features/results/watched";
import { count } from "@/lib/format";
import { describeEnd, describeScore, hitCells } from "@/lib/recordings";

import { AddToRanking } from "./AddToRanking";
import styles from "./TeachMore.module.css";

interface TeachMoreProps {
  results: RunResults;
  behaviour: Behaviour;
  onWatch: (watched: Watched) => void;
}

const SCREEN = { width: 320, height: 210 } as const;

/** Proposes games of the imitator for the ranking, and to train the imitator further. */
export function TeachMore({ results, behaviour, onWatch }: TeachMoreProps) {
  const games = results.proposed.flatMap(
    (id) => results.games.find(({ recording }) => recording.id === id) ?? [],
  );
  const at = `/behaviours/${behaviour.id}`;
  const further = (
    <ButtonLink to={`${at}/train?${new URLSearchParams({ continue: results.run.id }).toString()}`}>
      Train further from this imitator
    </ButtonLink>
  );
  if (games.length === 0) return <div className={styles.buttons}>{further}</div>;
  return (
    <>
      <p className={styles.note}>
        These games of the imitator differ most. Rank them among the others, the good ones high and
        the bad ones low, and train again: the reward learns what it has not understood. A run that
        learns from a game leaves the game&rsquo;s start out of its averages.
      </p>
      <ul className={styles.games} aria-label="Games to rank">
        {games.map((game) => (
          <ProposedGame
            key={game.recording.id}
            game={game}
            behaviour={behaviour}
            onWatch={onWatch}
          />
        ))}
      </ul>
      <div className={styles.buttons}>
        <AddAll games={games} behaviourId={behaviour.id} />
        {further}
      </div>
    </>
  );
}

function ProposedGame({
  game: { recording, action_selection: selection, start_number: start },
  behaviour,
  onWatch,
}: {
  game: EvaluationGame;
  behaviour: Behaviour;
  onWatch: (watched: Watched) => void;
}) {
  const how = `${selection} actions, start ${start}`;
  return (
    <li className={styles.game}>
      <button
        type="button"
        className={styles.watch}
        aria-label={`Watch imitator, ${how}`}
        onClick={() => onWatch({ recording, title: `Imitator, ${how}` })}
      >
        <RecordingScreen recording={recording} playing={false} {...SCREEN} />
      </button>
      <div className={styles.outcome}>
        <AlienGrid hits={hitCells(recording)} target={behaviour.target} label="" />
        <p>
          <b>{describeScore(recording, behaviour.target?.length ?? null)}</b>
          <span>{describeEnd(recording.end)}</span>
          <span>{how}</span>
        </p>
      </div>
      <AddToRanking recording={recording} behaviourId={behaviour.id} />
    </li>
  );
}

/** Adds all games to the unranked ones and leads there. */
function AddAll({ games, behaviourId }: { games: readonly EvaluationGame[]; behaviourId: number }) {
  const { data: borrowed } = useQuery(borrowedQuery(behaviourId));
  const { add, isPending } = useBorrowing(behaviourId);
  const navigate = useNavigate();
  const rank = `/behaviours/${behaviourId}/rank`;
  const held = new Set(borrowed?.map(({ id }) => id));
  const missing = games.map(({ recording }) => recording.id).filter((id) => !held.has(id));
  if (missing.length === 0) {
    return (
      <ButtonLink kind="primary" to={rank}>
        Rank them
      </ButtonLink>
    );
  }
  return (
    <Button
      kind="primary"
      icon="plus"
      disabled={isPending}
      onClick={() => void add(missing).then((added) => added && navigate(rank))}
    >
      Add {count(missing.length, "game")} and rank {missing.length === 1 ? "it" : "them"}
    </Button>
  );
}
