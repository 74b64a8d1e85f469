import { Plural, Trans } from "@lingui/react/macro";
import { useQuery } from "@tanstack/react-query";
import { Link } from "react-router";

import { undecidedQuery } from "@/api/recordings";
import type { Behaviour } from "@/api/types";
import { Notice } from "@/components/feedback/States";
import { KeepOrDiscard } from "@/components/recording/KeepOrDiscard";
import { useGame } from "@/games/game";
import { describeCourse, describeResult } from "@/games/outcomes";
import { isUndecided, recordingName } from "@/lib/recordings";

import styles from "./Undecided.module.css";

const MOST_SHOWN = 2;

/** The games that ended without being kept or discarded, apart from the one on the screen. */
export function Undecided({
  behaviour,
  besides,
}: {
  behaviour: Behaviour;
  besides: number | undefined;
}) {
  const game = useGame();
  const { data = [] } = useQuery(undecidedQuery(behaviour.id));
  const waiting = data.filter((one) => isUndecided(one) && one.id !== besides);
  if (waiting.length === 0) return null;
  const shown = waiting.slice(0, MOST_SHOWN);
  return (
    <Notice icon="clock">
      <div className={styles.undecided}>
        <p>
          <strong>
            <Plural
              value={waiting.length}
              one="# game waits for your decision"
              other="# games wait for your decision"
            />
          </strong>
        </p>
        {shown.map((recording) => (
          <div key={recording.id} className={styles.game}>
            <p>
              <Link to={`/recordings/${recording.id}`}>{recordingName(recording)}</Link>:{" "}
              {describeResult(recording, behaviour, game) || describeCourse(recording, game)}
            </p>
            <KeepOrDiscard recording={recording} />
          </div>
        ))}
        {waiting.length > shown.length && (
          <p>
            <Link to={`/behaviours/${behaviour.id}/recordings`}>
              <Trans>All of them</Trans>
            </Link>
          </p>
        )}
      </div>
    </Notice>
  );
}
