import { useId } from "react";

import styles from "./UnderstandingPanel.module.css";

/** What Tril is at, and how far. */
export function Progress({ share, children }: { share: number; children: string }) {
  const labelId = useId();
  return (
    <div className={styles.progress}>
      <p id={labelId}>{children}</p>
      <progress aria-labelledby={labelId} value={share} max={1} />
    </div>
  );
}
