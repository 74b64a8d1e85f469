import { Plural, Trans } from "@lingui/react/macro";
import { useState } from "react";

import { Button } from "@/components/controls/Button";

import styles from "./BlindCard.module.css";
import { BlindDialog } from "./BlindDialog";
import { useBlind } from "./use-blind";
import { describeBlind } from "./words";

/** Asks which games are closer to what was meant, and says what came of it. */
export function BlindCard({ runId }: { runId: string }) {
  const blind = useBlind(runId);
  const { comparison } = blind;
  /** The round whose result is shown; null to judge, undefined while it is closed. */
  const [open, setOpen] = useState<number | null>();
  if (!comparison || comparison.n_pairs === 0) return null;
  const { n_pairs: nPairs, answers, finished } = comparison;
  const nJudged = answers.length;
  const [latest] = finished;
  return (
    <section className={styles.card} aria-labelledby="blind-title">
      <h3 id="blind-title">
        <Trans>Which is closer to what you meant?</Trans>
      </h3>
      <p>
        {latest ? (
          describeBlind(latest.result)
        ) : (
          <Trans>
            Judge <Plural value={nPairs} one="a pair" other="# pairs" /> of games without knowing
            who played them: one is the imitator&rsquo;s, the other is the clone&rsquo;s or a
            demonstration.
          </Trans>
        )}
      </p>
      <div className={styles.buttons}>
        <Button icon="compare" onClick={() => setOpen(null)}>
          {nJudged > 0 ? (
            <Trans>
              Continue: {nJudged} of {nPairs} judged
            </Trans>
          ) : latest ? (
            <Trans>Compare more pairs</Trans>
          ) : (
            <Trans>Compare blind</Trans>
          )}
        </Button>
        {latest && (
          <Button kind="quiet" onClick={() => setOpen(latest.number)}>
            <Trans>Who played which</Trans>
          </Button>
        )}
      </div>
      {open !== undefined && (
        <BlindDialog
          runId={runId}
          blind={blind}
          comparison={comparison}
          told={open}
          onClose={() => setOpen(undefined)}
        />
      )}
    </section>
  );
}
