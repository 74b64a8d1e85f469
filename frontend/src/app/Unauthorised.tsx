import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import { Button } from "@/components/controls/Button";
import { Field } from "@/components/controls/Field";

import { Logo } from "./Logo";
import styles from "./pages.module.css";

/** Shown when this browser has no valid cookie. */
export function Unauthorised() {
  return (
    <main className={styles.lone}>
      <Logo scale={5} />
      <h1>
        <Trans>This browser isn&rsquo;t signed in yet</Trans>
      </h1>
      <p>
        <Trans>
          Tril prints an address with a key when it starts, on the last line in the terminal. Open
          that address once in this browser, or enter its key here. Has the line scrolled away?{" "}
          <code>tril address</code> in another terminal prints it again.
        </Trans>
      </p>
      <form action="/" className={styles.form}>
        <Field label={t`Key, or the whole address`}>
          {(control) => (
            <input {...control} name="token" type="password" autoComplete="off" required />
          )}
        </Field>
        <Button kind="primary" type="submit">
          <Trans>Sign in</Trans>
        </Button>
      </form>
    </main>
  );
}
