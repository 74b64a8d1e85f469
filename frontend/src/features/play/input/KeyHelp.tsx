import { Fragment } from "react";

import { useSetting } from "@/features/play/settings/stored";

import styles from "./KeyHelp.module.css";
import { type Control, keyName, KEYS } from "./keys";

/** The keys in use. */
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
