import styles from "./ShareBar.module.css";

/** A share as the filled part of a bar, beside which its percentage stands. */
export function ShareBar({ share }: { share: number }) {
  return (
    <span className={styles.bar} aria-hidden="true">
      <span style={{ inlineSize: `${100 * share}%` }} />
    </span>
  );
}
