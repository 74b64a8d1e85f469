import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";

import { useEffect } from "react";

import { Button } from "@/components/controls/Button";
import { Notice } from "@/components/feedback/States";
import { useToast } from "@/components/feedback/Toasts";
import { setUnsaved } from "@/lib/browser/drafts";

import styles from "./PeoplePage.module.css";

/** A link or key that was just made: only its hash is stored, so this is the time to copy it. */
export function Secret({ value }: { value: string }) {
  const toast = useToast();
  useEffect(() => {
    setUnsaved("secret", true);
    return () => setUnsaved("secret", false);
  }, []);
  const copy = async () => {
    try {
      // Denied by some browsers, and missing where the page came without encryption.
      await navigator.clipboard.writeText(value);
      toast(t`Copied.`);
    } catch {
      toast(t`Copying failed. Select the text and copy it.`);
    }
  };
  return (
    <Notice tone="calm" icon="check" live>
      <div className={styles.secret}>
        <p>
          <Trans>Copy it now; it is not shown again.</Trans>
        </p>
        <code>{value}</code>
        <Button onClick={() => void copy()}>
          <Trans>Copy</Trans>
        </Button>
      </div>
    </Notice>
  );
}
