import { Link } from "react-router";

import type { Behaviour } from "@/api/types";

import styles from "./Tip.module.css";

/** What to do with the recordings that are there. */
export function Tip({ behaviour }: { behaviour: Behaviour }) {
  const { n_recordings: n, id } = behaviour;
  if (n < 2) {
    return (
      <p className={styles.tip}>
        Two recordings are the least that can be ranked; about a dozen, from perfect to hopeless, is
        what an agent learns well from.
      </p>
    );
  }
  return (
    <p className={styles.tip}>
      {n} recordings so far. <Link to={`/behaviours/${id}/rank`}>Put them in order</Link> whenever
      you like.
    </p>
  );
}
