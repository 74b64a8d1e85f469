import { useRouteError } from "react-router";

import { messageOf } from "@/api/client";
import { Button } from "@/components/controls/Button";
import { Alien } from "@/components/game/AlienGrid";

import styles from "./pages.module.css";

/** The page itself failed: a defect. */
export function ErrorPage() {
  const error = useRouteError();
  return (
    <main className={styles.lone} role="alert">
      <Alien row={5} scale={5} />
      <h1>This page has failed</h1>
      <p>That is a defect in Tril. Nothing that was saved is lost; load the page again to go on.</p>
      <p className={styles.url}>{messageOf(error)}</p>
      <Button kind="primary" icon="restart" onClick={() => location.reload()}>
        Load the page again
      </Button>
    </main>
  );
}
