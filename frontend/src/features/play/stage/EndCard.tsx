import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { type RefObject, useImperativeHandle } from "react";

import type { Behaviour } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { usePerfectMark } from "@/components/recording/use-perfect-mark";
import type { Intent } from "@/features/play/input/intents";
import { ControlKey } from "@/features/play/input/ControlKey";
import { keyName } from "@/features/play/input/keys";
import type { Ended } from "@/features/play/stream/text-messages";
import { useGame } from "@/games/game";
import { describeResult, endSentence } from "@/games/outcomes";
import { inSentence } from "@/lib/format";
import { stepOf } from "@/lib/recordings";

import { Overlay } from "./Overlay";
import styles from "./Overlay.module.css";
import { useDecision } from "./use-decision";

/** Executes intents on the card. */
export interface EndCardHandle {
  execute: (intent: Intent) => void;
}

interface EndCardProps {
  ended: Ended;
  behaviour: Behaviour;
  handle: RefObject<EndCardHandle | null>;
  starting: boolean;
  onAgain: () => void;
  /** Continues from shortly before the end. */
  onRewind: () => void;
}

/** How a game ended, with the choice to keep, mark, discard or replay it. */
export function EndCard({ ended, behaviour, handle, starting, onAgain, onRewind }: EndCardProps) {
  const game = useGame();
  const empty = stepOf(ended.frame, game) === 0;
  const result = useDecision(behaviour.id, ended.recording_id, empty);
  const failed = ended.verification === "failed";
  const { decision, perfect, busy } = result;
  const { mark, question } = usePerfectMark(behaviour);

  function again() {
    // Undecided games are kept: bad games are useful, too.
    result.keep();
    onAgain();
  }

  function rewind() {
    result.keep();
    onRewind();
  }

  function togglePerfect() {
    if (perfect || decision === "discarded" || failed) result.togglePerfect();
    else mark([{ ...ended, end: ended.reason }], result.togglePerfect);
  }

  useImperativeHandle(handle, () => ({
    execute: (intent) => {
      if (intent === "keep") result.keep();
      else if (intent === "discard") result.discard();
      else if (intent === "perfect") togglePerfect();
      else if (intent === "again") again();
      else if (intent === "rewind" && game.saves_states && !failed && !empty) rewind();
    },
  }));

  const words = empty
    ? t`The game ended before its first step, so there is nothing to keep.`
    : describeResult(ended, behaviour, game);
  return (
    <Overlay>
      <div role="status" aria-live="polite">
        <p className={styles.big} style={{ color: "inherit" }}>
          {empty ? t`Nothing was played` : endSentence(ended, game)}
        </p>
        {words && <p>{words}</p>}
        {failed && (
          <p>
            <Trans>
              A replay didn&rsquo;t reproduce the game: {ended.verification_note} It can&rsquo;t be
              ranked.
            </Trans>
          </p>
        )}
        {!empty && <p>{decisionSentence(decision, perfect, result.name)}</p>}
      </div>
      <div className={styles.actions}>
        {decision === "open" && (
          <Button kind="primary" onClick={result.keep} disabled={busy}>
            <Trans>
              Keep <kbd>K</kbd>
            </Trans>
          </Button>
        )}
        {decision !== "discarded" && (
          <>
            <Button
              icon="star"
              aria-pressed={perfect}
              onClick={togglePerfect}
              disabled={busy || failed}
            >
              <Trans>
                Perfect <kbd>P</kbd>
              </Trans>
            </Button>
            <Button onClick={result.discard} disabled={busy}>
              <Trans>
                Discard <kbd>X</kbd>
              </Trans>
            </Button>
          </>
        )}
        {!empty && game.saves_states && (
          <Button
            icon="undo"
            onClick={rewind}
            disabled={starting || failed}
            title={t`Keeps this game, and plays on from two seconds before its end`}
          >
            <Trans>Rewind</Trans> <ControlKey control="rewind" />
          </Button>
        )}
        <Button
          kind={decision === "open" ? "secondary" : "primary"}
          onClick={again}
          disabled={starting}
        >
          {starting ? t`Starting…` : decision === "open" ? t`Keep and play again` : t`Play again`}{" "}
          <kbd>{keyName("Space")}</kbd>
        </Button>
      </div>
      {question}
    </Overlay>
  );
}

function decisionSentence(
  decision: "open" | "kept" | "discarded",
  perfect: boolean,
  recording: string,
): string {
  if (decision === "kept") {
    const name = inSentence(recording);
    return perfect ? t`Kept as ${name}, marked as perfect.` : t`Kept as ${name}.`;
  }
  return decision === "discarded" ? t`Discarded.` : "";
}
