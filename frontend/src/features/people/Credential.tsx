import type { ReactNode } from "react";

import { Button } from "@/components/controls/Button";

import styles from "./PeoplePage.module.css";

interface CredentialProps {
  /** Whom or what it lets in. */
  children: ReactNode;
  /** A line below: when it was made or used. */
  note: ReactNode;
  /** The button that ends it; none where it cannot be ended here. */
  end?: { label: string; name: string; disabled: boolean; onClick: () => void } | undefined;
}

/** What lets somebody in, a row of a list, with the button that ends it. */
export function Credential({ children, note, end }: CredentialProps) {
  return (
    <li>
      <span className={styles.what}>
        {children}
        <small>{note}</small>
      </span>
      {end && (
        <Button aria-label={end.name} disabled={end.disabled} onClick={end.onClick}>
          {end.label}
        </Button>
      )}
    </li>
  );
}
