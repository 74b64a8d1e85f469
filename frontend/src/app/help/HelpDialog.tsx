import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useLocation } from "react-router";

import { ButtonLink } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
import { KEYS, useKeyNames } from "@/features/play/input/keys";
import { useSetting } from "@/features/play/settings/stored";

import styles from "./HelpDialog.module.css";
import { keySections } from "./page-keys";

/** The keys that act on this page, and the way to the tour. */
export function HelpDialog({ onClose }: { onClose: () => void }) {
  const { pathname } = useLocation();
  const [keys] = useSetting(KEYS);
  const nameOf = useKeyNames();
  return (
    <Dialog title={t`Keys on this page`} onClose={onClose} width="30rem">
      <div className={styles.body}>
        {keySections(pathname, keys, nameOf).map(({ title, rows }) => (
          <section key={title} aria-label={title}>
            <h3>{title}</h3>
            <dl className={styles.keys}>
              {rows.map((row) => (
                <div key={row.effect} style={{ display: "contents" }}>
                  <dt>
                    {row.keys.map((key) => (
                      <kbd key={key}>{key}</kbd>
                    ))}
                  </dt>
                  <dd>{row.effect}</dd>
                </div>
              ))}
            </dl>
          </section>
        ))}
        <div>
          <ButtonLink to="/?tour" onClick={onClose}>
            <Trans>Take the tour of Tril</Trans>
          </ButtonLink>
        </div>
      </div>
    </Dialog>
  );
}
