import type { CSSProperties, ReactNode } from "react";

import { messageOf } from "@/api/client";
import { Button } from "@/components/controls/Button";
import { Icon, type IconName } from "@/components/controls/Icon";
import { classes } from "@/lib/classes";

import styles from "./States.module.css";

/** Stands where something will be, at about its size. */
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
      <span className="visually-hidden">Loading {what}…</span>
      {Array.from({ length: rows }, (_, row) => (
        <i key={row} />
      ))}
    </div>
  );
}

/** Nothing is here yet: why, and what to do next. */
export function Empty({
  title,
  children,
  actions,
}: {
  title: string;
  children?: ReactNode;
  actions?: ReactNode;
}) {
  return (
    <div className={styles.state}>
      <h2>{title}</h2>
      {children}
      {actions && <div className={styles.actions}>{actions}</div>}
    </div>
  );
}

/** Something could not be loaded: why, and a way to try again. */
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
      <h2>{what} could not be loaded</h2>
      <p>{messageOf(error)}</p>
      {onRetry && (
        <div className={styles.actions}>
          <Button icon="restart" onClick={onRetry}>
            Try again
          </Button>
        </div>
      )}
    </div>
  );
}

/** A remark in its place on the page. */
export function Notice({
  tone = "warn",
  icon = "alert",
  live = false,
  children,
}: {
  tone?: "warn" | "bad" | "calm";
  icon?: IconName;
  /** Whether it appears while somebody is reading the page and should be spoken. */
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
