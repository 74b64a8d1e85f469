import type { Behaviour } from "@/api/types";
import { Button } from "@/components/controls/Button";
import type { BranchPair, Verdict } from "@/features/ranking/order/branch-pairs";
import { FRAME_RATE_HZ, seconds } from "@/lib/format";
import { courseInWords, recordingName, scoreInWords } from "@/lib/recordings";

import styles from "./Pairs.module.css";

interface PairsProps {
  pairs: readonly BranchPair[];
  behaviour: Behaviour;
  onLook: (id: number) => void;
  onJudge: (pair: BranchPair, verdict: Verdict) => void;
}

/** Games that were run back and went on in another way, ready to be compared. */
export function Pairs({ pairs, behaviour, onLook, onJudge }: PairsProps) {
  const [pair] = pairs;
  if (!pair) return null;
  const { before, after, frame } = pair;
  const nTargets = behaviour.target?.length ?? null;
  return (
    <section className={styles.pairs} aria-label="Pairs to compare">
      <h3>Which way was better? ({pairs.length})</h3>
      <p>
        {recordingName(after)} goes on from {recordingName(before)} at{" "}
        {seconds(frame / FRAME_RATE_HZ)}.
      </p>
      <ul>
        {[after, before].map((one) => (
          <li key={one.id}>
            <Button kind="quiet" icon="eye" onClick={() => onLook(one.id)}>
              {recordingName(one)}
            </Button>
            <span>
              {scoreInWords(one, nTargets)}; {courseInWords(one)}
            </span>
          </li>
        ))}
      </ul>
      <div className={styles.verdicts}>
        <Button onClick={() => onJudge(pair, "after")}>{after.id} is better</Button>
        <Button onClick={() => onJudge(pair, "equal")}>Equally good</Button>
        <Button onClick={() => onJudge(pair, "before")}>{before.id} is better</Button>
      </div>
    </section>
  );
}
