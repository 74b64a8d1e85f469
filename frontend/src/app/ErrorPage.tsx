import { Trans } from "@lingui/react/macro";
import { useRouteError } from "react-router";

import { messageOf } from "@/api/client";
import { Button } from "@/components/controls/Button";

import { Logo } from "./Logo";
import styles from "./pages.module.css";

/** Shown when rendering throws. */
export function ErrorPage() {
  const error = useRouteError();
  return (
    <main className={styles.lone} role="alert">
      <Logo scale={5} />
      <h1>
        <Trans>This page crashed</Trans>
      </h1>
      <p>
        <Trans>
          That is a bug in Tril. Nothing that was saved is lost; reload the page to continue.
        </Trans>
      </p>
      <p className={styles.url}>{messageOf(error)}</p>
      <Button kind="primary" icon="restart" onClick={() => location.reload()}>
        <Trans>Reload the page</Trans>
      </Button>
    </main>
  );
}
