import type { ReactNode } from "react";

import styles from "./Legend.module.css";

/** The line below a plot over time: what it shows, and its value at the current frame. */
export function Legend({ children }: { children: ReactNode }) {
  return <p className={styles.legend}>{children}</p>;
}
