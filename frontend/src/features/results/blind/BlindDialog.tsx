import { t } from "@lingui/core/macro";
import { Plural, Trans } from "@lingui/react/macro";
import { useEffect, useRef, useState } from "react";

import { messageOf } from "@/api/client";
import type { BlindComparison } from "@/api/types";
import { Button } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
import { Notice } from "@/components/feedback/States";

import styles from "./BlindDialog.module.css";
import { BlindPair } from "./BlindPair";
import { BlindResult } from "./BlindResult";
import type { Blind } from "./use-blind";

interface BlindDialogProps {
  runId: string;
  blind: Blind;
  comparison: BlindComparison;
  /** The round whose result it opens with; null to judge. */
  told: number | null;
  onClose: () => void;
}

/** Judges the pairs of a round, which is kept after each, and tells what came of it. */
export function BlindDialog({ runId, blind, comparison, told, onClose }: BlindDialogProps) {
  const { round, n_pairs: nPairs, answers, finished } = comparison;
  // The round that is judged here stays, even once it is over.
  const [shown] = useState(told ?? round);
  const ended = finished.find(({ number }) => number === shown);
  const isJudging = !ended && answers.length < nPairs;
  return (
    <Dialog
      title={ended ? t`Who played which` : t`Which is closer to what you meant?`}
      width={isJudging ? "160rem" : "60rem"}
      onClose={onClose}
    >
      <div className={styles.body}>
        {blind.error !== null && (
          <Notice tone="bad" live>
            <p>{messageOf(blind.error)}</p>
          </Notice>
        )}
        {ended ? (
          <>
            <BlindResult runId={runId} finished={ended} />
            <Done onClose={onClose} />
          </>
        ) : isJudging ? (
          <BlindPair blind={blind} comparison={comparison} />
        ) : (
          <AllJudged blind={blind} nPairs={nPairs} />
        )}
      </div>
    </Dialog>
  );
}

function AllJudged({ blind, nPairs }: { blind: Blind; nPairs: number }) {
  const next = useFocus();
  return (
    <>
      <p role="status">
        <Plural value={nPairs} one="The pair is judged." other="All # pairs are judged." />
      </p>
      <div className={styles.buttons}>
        <Button kind="primary" ref={next} onClick={() => blind.answer("ended")}>
          <Trans>Show who played which</Trans>
        </Button>
        <Button icon="undo" onClick={() => blind.answer("taken back")}>
          <Trans>Undo the last answer</Trans>
        </Button>
      </div>
    </>
  );
}

function Done({ onClose }: { onClose: () => void }) {
  const next = useFocus();
  return (
    <div className={styles.buttons}>
      <Button kind="primary" ref={next} onClick={onClose}>
        <Trans>Back to the run</Trans>
      </Button>
    </div>
  );
}

/** Focuses a button in place of those that had the focus and are gone. */
function useFocus() {
  const button = useRef<HTMLButtonElement>(null);
  useEffect(() => button.current?.focus({ preventScroll: true }), []);
  return button;
}
