import { Link } from "react-router";

import type { Behaviour } from "@/api/types";
import { count } from "@/lib/format";

import styles from "./Tip.module.css";

/** A hint on what to do next. */
export function Tip({ behaviour }: { behaviour: Behaviour }) {
  const { n_recordings: n, id } = behaviour;
  if (n < 2) {
    return (
      <p className={styles.tip}>
        Ranking takes at least two recordings; an agent learns well from about a dozen, from perfect
        to hopeless.
      </p>
    );
  }
  return (
    <p className={styles.tip}>
      {count(n, "recording")} so far. <Link to={`/behaviours/${id}/rank`}>Put them in order</Link>{" "}
      whenever you like.
    </p>
  );
}
