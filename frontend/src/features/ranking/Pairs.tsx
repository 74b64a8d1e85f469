import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { Behaviour } from "@/api/types";
import { Button } from "@/components/controls/Button";
import type { BranchPair, Verdict } from "@/features/ranking/order/branch-pairs";
import { useGame } from "@/games/game";
import { describeCourse, describeResult } from "@/games/outcomes";
import { seconds } from "@/lib/format";
import { recordingName } from "@/lib/recordings";

import styles from "./Pairs.module.css";

interface PairsProps {
  pairs: readonly BranchPair[];
  behaviour: Behaviour;
  onPreview: (id: number) => void;
  onJudge: (pair: BranchPair, verdict: Verdict) => void;
}

/** Asks which of two branches of a game is better. */
export function Pairs({ pairs, behaviour, onPreview, onJudge }: PairsProps) {
  const game = useGame();
  const [pair] = pairs;
  if (!pair) return null;
  const { before, after, frame } = pair;
  return (
    <section className={styles.pairs} aria-label={t`Pairs to compare`}>
      <h3>
        <Trans>Which version is better? ({pairs.length})</Trans>
      </h3>
      <p>
        <Trans>
          {recordingName(after)} branches off {recordingName(before)} at{" "}
          {seconds(frame / game.frame_rate_hz)}.
        </Trans>
      </p>
      <ul>
        {[after, before].map((one) => (
          <li key={one.id}>
            <Button kind="quiet" icon="eye" onClick={() => onPreview(one.id)}>
              {recordingName(one)}
            </Button>
            <span>
              {[describeResult(one, behaviour, game), describeCourse(one, game)]
                .filter(Boolean)
                .join("; ")}
            </span>
          </li>
        ))}
      </ul>
      <div className={styles.verdicts}>
        <Button onClick={() => onJudge(pair, "after")}>
          <Trans>{recordingName(after)} is better</Trans>
        </Button>
        <Button onClick={() => onJudge(pair, "equal")}>
          <Trans>Equally good</Trans>
        </Button>
        <Button onClick={() => onJudge(pair, "before")}>
          <Trans>{recordingName(before)} is better</Trans>
        </Button>
      </div>
    </section>
  );
}
