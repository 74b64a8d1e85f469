import { type RefObject, useImperativeHandle } from "react";

import type { Behaviour } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { usePerfectMark } from "@/components/recording/use-perfect-mark";
import type { Intent } from "@/features/play/input/intents";
import type { Ended } from "@/features/play/stream/text-messages";

import { endSentence, scoreSentence } from "./outcome-words";
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
  const result = useDecision(behaviour.id, ended.recording_id);
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
      else if (intent === "rewind" && !failed) rewind();
    },
  }));

  return (
    <Overlay>
      <div role="status" aria-live="polite">
        <p className={styles.big} style={{ color: "inherit" }}>
          {endSentence(ended)}
        </p>
        <p>{scoreSentence(ended, behaviour)}</p>
        {failed && (
          <p>
            A replay didn&rsquo;t reproduce the game: {ended.verification_note} It can&rsquo;t be
            ranked.
          </p>
        )}
        <p>{decisionSentence(decision, perfect, ended.recording_id)}</p>
      </div>
      <div className={styles.actions}>
        {decision === "open" && (
          <Button kind="primary" onClick={result.keep} disabled={busy}>
            Keep <kbd>K</kbd>
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
              Perfect <kbd>P</kbd>
            </Button>
            <Button onClick={result.discard} disabled={busy}>
              Discard <kbd>X</kbd>
            </Button>
          </>
        )}
        <Button
          icon="undo"
          onClick={rewind}
          disabled={starting || failed}
          title="Keeps this game, and plays on from two seconds before its end"
        >
          Rewind <kbd>⌫</kbd>
        </Button>
        <Button
          kind={decision === "open" ? "secondary" : "primary"}
          onClick={again}
          disabled={starting}
          title={decision === "open" ? "Keeps this game and starts another one" : undefined}
        >
          {starting ? "Starting…" : "Play again"} <kbd>Space</kbd>
        </Button>
      </div>
      {question}
    </Overlay>
  );
}

function decisionSentence(
  decision: "open" | "kept" | "discarded",
  perfect: boolean,
  id: number,
): string {
  if (decision === "kept") return `Kept as recording ${id}${perfect ? ", marked as perfect" : ""}.`;
  return decision === "discarded" ? "Discarded." : "";
}
