import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { Fragment } from "react";

import { useSetting } from "@/features/play/settings/stored";

import styles from "./KeyHelp.module.css";
import { type Control, KEYS, useKeyNames } from "./keys";

/** The keys in use. */
export function KeyHelp() {
  const [keys] = useSetting(KEYS);
  const nameOf = useKeyNames();
  const names = (control: Control) =>
    keys[control].map((code) => (
      <Fragment key={code}>
        <kbd>{nameOf(code)}</kbd>{" "}
      </Fragment>
    ));
  return (
    <dl className={styles.keys} aria-label={t`Keys`}>
      <dt>
        {names("left")}
        {names("right")}
      </dt>
      <dd>
        <Trans>move</Trans>
      </dd>
      <dt>{names("fire")}</dt>
      <dd>
        <Trans>fire, may be held</Trans>
      </dd>
      <dt>{names("rewind")}</dt>
      <dd>
        <Trans>rewind while held</Trans>
      </dd>
      <dt>{names("pause")}</dt>
      <dd>
        <Trans>pause</Trans>
      </dd>
      <dt>
        <kbd>.</kbd>
      </dt>
      <dd>
        <Trans>frame by frame</Trans>
      </dd>
    </dl>
  );
}
