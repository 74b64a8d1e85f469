import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { Fragment } from "react";

import { buttonName } from "@/games/actions";
import { useGame } from "@/games/game";

import styles from "./KeyHelp.module.css";
import { type Control, useKeyMap, useKeyNames } from "./keys";
import { DIRECTIONS } from "./directions";

/** The keys in use. */
export function KeyHelp() {
  const { buttons, saves_states: canRewind } = useGame();
  const [keys] = useKeyMap();
  const nameOf = useKeyNames();
  const names = (controls: readonly Control[]) =>
    controls
      .flatMap((control) => keys[control] ?? [])
      .map((code) => (
        <Fragment key={code}>
          <kbd>{nameOf(code)}</kbd>{" "}
        </Fragment>
      ));
  const directions = DIRECTIONS.filter((one) => buttons.includes(one));
  const others = buttons.filter((one) => !directions.some((direction) => direction === one));
  return (
    <dl className={styles.keys} aria-label={t`Keys`}>
      {directions.length > 0 && (
        <>
          <dt>{names(directions)}</dt>
          <dd>
            <Trans>move</Trans>
          </dd>
        </>
      )}
      {others.map((button) => (
        <Fragment key={button}>
          <dt>{names([button])}</dt>
          <dd>{button === "fire" ? t`fire, may be held` : buttonName(button)}</dd>
        </Fragment>
      ))}
      {canRewind && (
        <>
          <dt>{names(["rewind"])}</dt>
          <dd>
            <Trans>rewind while held</Trans>
          </dd>
        </>
      )}
      <dt>{names(["pause"])}</dt>
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
