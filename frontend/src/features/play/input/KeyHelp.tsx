import { Fragment } from "react";
import { Link } from "react-router";

import type { Behaviour } from "@/api/types";
import styles from "@/features/play/PlayPage.module.css";
import { useSetting } from "@/features/play/settings/stored";

import { type Control, keyName, KEYS } from "./keys";

/** Which keys do what. */
export function KeyHelp() {
  const [keys] = useSetting(KEYS);
  const names = (control: Control) =>
    keys[control].map((code) => (
      <Fragment key={code}>
        <kbd>{keyName(code)}</kbd>{" "}
      </Fragment>
    ));
  return (
    <dl className={styles.keys} aria-label="Keys">
      <dt>
        {names("left")}
        {names("right")}
      </dt>
      <dd>move</dd>
      <dt>{names("fire")}</dt>
      <dd>fire, may be held</dd>
      <dt>{names("rewind")}</dt>
      <dd>rewind while held</dd>
      <dt>{names("pause")}</dt>
      <dd>pause</dd>
      <dt>
        <kbd>.</kbd>
      </dt>
      <dd>frame by frame</dd>
    </dl>
  );
}

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
