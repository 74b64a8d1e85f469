import { Trans } from "@lingui/react/macro";
import type { CSSProperties, ReactElement, ReactNode } from "react";

import { messageOf } from "@/api/client";
import { Button } from "@/components/controls/Button";
import { Icon, type IconName } from "@/components/controls/Icon";
import { classes } from "@/lib/classes";

import styles from "./States.module.css";

/** A placeholder of about the size of what is loading. */
export function Loading({
  what,
  rows = 3,
  height = "4rem",
}: {
  /** What is being loaded, for screen readers. */
  what: string;
  rows?: number;
  height?: string;
}) {
  return (
    <div className={styles.skeleton} role="status" style={{ "--height": height } as CSSProperties}>
      <span className="visually-hidden">
        <Trans>Loading {what}…</Trans>
      </span>
      {Array.from({ length: rows }, (_, row) => (
        <i key={row} />
      ))}
    </div>
  );
}

/** An empty state: what is missing and what to do next. */
export function Empty({
  title,
  level: Heading = "h2",
  picture,
  children,
  actions,
}: {
  title: string;
  /** What it is about: a URL, or what is drawn on a screen. */
  picture?: string | ReactElement;
  /** "h1" where it is all that the page has. */
  level?: "h1" | "h2";
  children?: ReactNode;
  actions?: ReactNode;
}) {
  return (
    <div className={classes(styles.state, picture !== undefined && styles.pictured)}>
      {typeof picture === "string" ? (
        <img className={styles.picture} src={picture} alt="" />
      ) : (
        picture && <div className={styles.picture}>{picture}</div>
      )}
      <Heading>{title}</Heading>
      {children}
      {actions && <div className={styles.actions}>{actions}</div>}
    </div>
  );
}

/** An error state: what could not be loaded, why, and a retry button. */
export function Failed({
  what,
  error,
  onRetry,
}: {
  what: string;
  error: unknown;
  onRetry?: () => void;
}) {
  return (
    <div className={styles.state} role="alert">
      <h2>
        <Trans>{what} could not be loaded</Trans>
      </h2>
      <p>{messageOf(error)}</p>
      {onRetry && (
        <div className={styles.actions}>
          <Button icon="restart" onClick={onRetry}>
            <Trans>Try again</Trans>
          </Button>
        </div>
      )}
    </div>
  );
}

/** An inline message. */
export function Notice({
  tone = "warn",
  icon = "alert",
  live = false,
  children,
}: {
  tone?: "warn" | "bad" | "calm";
  icon?: IconName;
  /** Whether it appears after the page was shown and so has to be announced. */
  live?: boolean;
  children: ReactNode;
}) {
  return (
    <div
      className={classes(
        styles.notice,
        tone === "bad" && styles.bad,
        tone === "calm" && styles.calm,
      )}
      role={live ? (tone === "bad" ? "alert" : "status") : undefined}
    >
      <Icon name={icon} />
      <div className={styles.noticeBody}>{children}</div>
    </div>
  );
}
