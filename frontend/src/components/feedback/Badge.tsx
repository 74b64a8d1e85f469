import type { ReactNode } from "react";

import { Icon, type IconName } from "@/components/controls/Icon";
import { classes } from "@/lib/classes";

import styles from "./Badge.module.css";

interface BadgeProps {
  tone?: "accent" | "good" | "warn" | "bad";
  icon?: IconName;
  /** Whether it has a border. */
  chip?: boolean;
  title?: string;
  children: ReactNode;
}

/** A short fact in small print. */
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
