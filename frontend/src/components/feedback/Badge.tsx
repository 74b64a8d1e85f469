import type { ReactNode } from "react";

import { Icon, type IconName } from "@/components/controls/Icon";
import { classes } from "@/lib/classes";

import styles from "./Badge.module.css";

interface BadgeProps {
  tone?: "accent" | "good" | "warn" | "bad";
  icon?: IconName;
  /** Draws a border around it. */
  chip?: boolean;
  title?: string;
  children: ReactNode;
}

/** A short fact beside a name. */
export function Badge({ tone, icon, chip = false, title, children }: BadgeProps) {
  return (
    <span
      className={classes(styles.badge, chip && styles.chip, tone && styles[tone])}
      title={title}
    >
      {icon && <Icon name={icon} />}
      {children}
    </span>
  );
}
