import { Alien } from "@/components/game/AlienGrid";

import styles from "./pages.module.css";

/** Shown when this browser has no valid cookie. */
export function Unauthorised() {
  return (
    <main className={styles.lone}>
      <Alien row={2} scale={5} />
      <h1>This browser isn&rsquo;t signed in yet</h1>
      <p>
        Tril prints an address with a token when it starts, on the last line in the terminal. Open
        that address once in this browser; after that, this page works without it.
      </p>
      <p className={styles.url}>{location.origin}/?token=…</p>
      <p>
        Has the line scrolled away? <code>tril address</code> in another terminal prints it again.
      </p>
    </main>
  );
}
