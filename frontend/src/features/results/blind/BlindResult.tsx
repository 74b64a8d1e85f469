import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { Link } from "react-router";

import type { FinishedBlindRound, Recording, RevealedPair } from "@/api/types";
import { ActorMark } from "@/components/game/ActorMark";
import { type Actor, actorNames } from "@/lib/actors";
import { GamePicture, LOOPS } from "@/components/recording/GamePicture";
import { classes } from "@/lib/classes";

import styles from "./BlindResult.module.css";
import { describeBlind } from "./words";

interface BlindResultProps {
  runId: string;
  finished: FinishedBlindRound;
}

/** What came of a round, and whose games they were. */
export function BlindResult({ runId, finished: { result, pairs } }: BlindResultProps) {
  return (
    <div className={styles.result}>
      <p className={styles.told} role="status">
        {describeBlind(result)}
      </p>
      <p className={styles.note}>
        <Trans>In brackets: 95% interval of the share. Equally close counts half.</Trans>
      </p>
      <ol className={styles.pairs} aria-label={t`Who played which`}>
        {pairs.map((pair, index) => (
          <li key={index}>
            <Pair runId={runId} pair={pair} />
          </li>
        ))}
      </ol>
    </div>
  );
}

function Pair({ runId, pair }: { runId: string; pair: RevealedPair }) {
  const { opponent, imitator, other, imitator_left: isLeft, answer } = pair;
  const games = [
    { actor: "imitator" as const, recording: imitator },
    { actor: opponent, recording: other },
  ];
  const [left, right] = isLeft ? games : games.toReversed();
  return (
    <>
      {left && <Game {...left} runId={runId} verdict={verdictOn("left", answer)} />}
      {right && <Game {...right} runId={runId} verdict={verdictOn("right", answer)} />}
    </>
  );
}

/** Returns what was said of a side; null if the other one was chosen. */
function verdictOn(side: "left" | "right", answer: RevealedPair["answer"]): string | null {
  if (answer === "equal") return t`equally close`;
  return answer === side ? t`closer` : null;
}

interface GameProps {
  actor: Actor;
  recording: Recording;
  runId: string;
  verdict: string | null;
}

function Game({ actor, recording, runId, verdict }: GameProps) {
  return (
    <Link
      to={`/recordings/${recording.id}?run=${runId}`}
      className={classes(styles.game, verdict !== null && styles.chosen)}
      {...LOOPS}
    >
      <GamePicture recording={recording} />
      <span>
        <ActorMark actor={actor}>{actorNames()[actor]}</ActorMark>
        {verdict !== null && <b>{verdict}</b>}
      </span>
    </Link>
  );
}
