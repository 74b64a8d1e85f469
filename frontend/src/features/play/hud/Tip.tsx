import { Plural, Trans } from "@lingui/react/macro";
import { Link } from "react-router";

import type { Behaviour } from "@/api/types";

import styles from "./Tip.module.css";

/** A hint on what to do next. */
export function Tip({ behaviour }: { behaviour: Behaviour }) {
  const { n_recordings: n, id } = behaviour;
  if (n < 2) {
    return (
      <p className={styles.tip}>
        <Trans>
          Ranking takes at least two recordings. Ten usually tell what you mean: some at your best,
          the others from good to hopeless.
        </Trans>
      </p>
    );
  }
  return (
    <p className={styles.tip}>
      <Trans>
        <Plural value={n} one="# recording so far." other="# recordings so far." />{" "}
        <Link to={`/behaviours/${id}/rank`}>Put them in order</Link> whenever you like.
      </Trans>
    </p>
  );
}
