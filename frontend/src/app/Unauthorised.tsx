import styles from "./pages.module.css";

import { Alien } from "@/components/AlienGrid";

/** This browser has no valid cookie. */
export function Unauthorised() {
  return (
    <main className={styles.lone}>
      <Alien row={2} scale={5} />
      <h1>This browser isn&rsquo;t let in yet</h1>
      <p>
        Tril prints an address with a token when it starts, on the last line in the terminal. Open
        that address once in this browser; after that, this page works without it.
      </p>
      <p className={styles.url}>http://127.0.0.1:8000/?token=…</p>
      <p>
        The line has scrolled away? Stop Tril with <kbd>Ctrl</kbd> <kbd>C</kbd> and start it again:
        it prints the same address.
      </p>
    </main>
  );
}
