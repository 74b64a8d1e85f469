import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import type { RankingCheck } from "@/api/types";
import { ShareBar } from "@/components/ShareBar";
import { percent } from "@/lib/format";

import styles from "./Statements.module.css";

/** What Tril says that the order is about, the most probable first. */
export function Statements({ statements, answers }: Pick<RankingCheck, "statements" | "answers">) {
  return (
    <section className={styles.statements} aria-labelledby="statements-title">
      <h3 id="statements-title">
        <Trans>What Tril understood: better games have</Trans>
      </h3>
      <ol>
        {statements.map(({ sentence, probability }) => (
          <li key={sentence}>
            <span className={styles.sentence}>{sentence}</span>
            <ShareBar share={probability} />
            <span className={styles.share}>{percent(probability, 0)}</span>
          </li>
        ))}
      </ol>
      {answers.length > 0 && (
        <ul aria-label={t`What you had told Tril`}>
          {answers.map(({ sentence, meant }) => (
            <li key={sentence} className={styles.told}>
              {meant ? (
                <Trans>You had said that this is it: {sentence}</Trans>
              ) : (
                <Trans>You had said that it is not this: {sentence}</Trans>
              )}
            </li>
          ))}
        </ul>
      )}
    </section>
  );
}
