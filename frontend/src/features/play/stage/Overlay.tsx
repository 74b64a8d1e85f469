import type { ReactNode } from "react";

import { classes } from "@/lib/classes";

import styles from "./Overlay.module.css";

/** A layer over the game's screen. */
export function Overlay({
  opaque = false,
  className,
  children,
}: {
  opaque?: boolean;
  className?: string | undefined;
  children: ReactNode;
}) {
  return (
    <div className={classes(styles.overlay, opaque && styles.opaque, className)}>{children}</div>
  );
}
