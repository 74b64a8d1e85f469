import { useQuery } from "@tanstack/react-query";
import { Link } from "react-router";

import { recordingsQuery } from "@/api/recordings";
import type { Behaviour } from "@/api/types";
import { Notice } from "@/components/feedback/States";
import { KeepOrDiscard } from "@/components/recording/KeepOrDiscard";
import { count } from "@/lib/format";
import { describeScore, isUndecided, recordingName } from "@/lib/recordings";

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
  const { data = [] } = useQuery(recordingsQuery(behaviour.id));
  const waiting = data.filter((one) => isUndecided(one) && one.id !== besides);
  if (waiting.length === 0) return null;
  const shown = waiting.slice(0, MOST_SHOWN);
  return (
    <Notice icon="clock">
      <div className={styles.undecided}>
        <p>
          <strong>
            {count(waiting.length, "game")} {waiting.length === 1 ? "waits" : "wait"} for your
            decision
          </strong>
        </p>
        {shown.map((recording) => (
          <div key={recording.id} className={styles.game}>
            <p>
              <Link to={`/recordings/${recording.id}`}>{recordingName(recording)}</Link>:{" "}
              {describeScore(recording, behaviour.target?.length ?? null)}
            </p>
            <KeepOrDiscard recording={recording} />
          </div>
        ))}
        {waiting.length > shown.length && (
          <p>
            <Link to={`/behaviours/${behaviour.id}/recordings`}>All of them</Link>
          </p>
        )}
      </div>
    </Notice>
  );
}
