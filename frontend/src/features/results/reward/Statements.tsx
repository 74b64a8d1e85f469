import { Trans } from "@lingui/react/macro";

import type { RankingCheck } from "@/api/types";
import { percent } from "@/lib/format";

import styles from "./Statements.module.css";

/** What Tril says that the order is about, the most probable first. */
export function Statements({ statements }: Pick<RankingCheck, "statements">) {
  return (
    <section className={styles.statements} aria-labelledby="statements-title">
      <h4 id="statements-title">
        <Trans>What Tril understood: better games have</Trans>
      </h4>
      <ol>
        {statements.map(({ sentence, probability }) => (
          <li key={sentence}>
            <span className={styles.sentence}>{sentence}</span>
            <span className={styles.bar} aria-hidden="true">
              <span style={{ inlineSize: percent(probability) }} />
            </span>
            <span className={styles.share}>{percent(probability)}</span>
          </li>
        ))}
      </ol>
    </section>
  );
}
