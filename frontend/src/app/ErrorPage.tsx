import { useRouteError } from "react-router";

import styles from "./pages.module.css";

import { messageOf } from "@/api/client";
import { Alien } from "@/components/AlienGrid";
import { Button } from "@/components/Button";

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
