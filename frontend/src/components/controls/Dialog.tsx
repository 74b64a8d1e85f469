import { t } from "@lingui/core/macro";
import { type CSSProperties, type ReactNode, useId, useLayoutEffect, useRef } from "react";

import { IconButton } from "./Button";
import styles from "./Dialog.module.css";

interface DialogProps {
  title: ReactNode;
  /** Omit it to force a choice between the dialog's buttons. */
  onClose?: () => void;
  /** As a CSS length. */
  width?: string;
  children: ReactNode;
}

const FIELDS = "[data-first], input:not([type=file], [type=range]), textarea, select";

/**
 * A modal dialog, open while it is rendered. Escape, the close button and a click on the backdrop
 * call `onClose`. The focus begins at the first field or at what has `data-first`, stays in the dialog and goes
 * back to where it was.
 */
export function Dialog({ title, onClose, width, children }: DialogProps) {
  const ref = useRef<HTMLDialogElement>(null);
  const titleId = useId();

  // Not after painting: then the dialog has left the document before it could restore the focus.
  useLayoutEffect(() => {
    const dialog = ref.current;
    if (!dialog) return undefined;
    const before = document.activeElement;
    if (!dialog.open) dialog.showModal();
    dialog.querySelector<HTMLElement>(FIELDS)?.focus();
    return () => {
      dialog.close();
      if (before instanceof HTMLElement) before.focus();
    };
  }, []);

  return (
    // The click is on the backdrop, which has no element of its own; Escape does the same.
    // eslint-disable-next-line jsx-a11y/click-events-have-key-events, jsx-a11y/no-noninteractive-element-interactions
    <dialog
      ref={ref}
      className={styles.dialog}
      aria-labelledby={titleId}
      style={width ? ({ "--dialog-width": width } as CSSProperties) : undefined}
      onCancel={(event) => {
        event.preventDefault();
        onClose?.();
      }}
      onClick={(event) => {
        if (event.target === event.currentTarget) onClose?.();
      }}
    >
      <div className={styles.head}>
        <h2 id={titleId}>{title}</h2>
        {onClose && <IconButton icon="close" label={t`Close`} onClick={onClose} />}
      </div>
      <div className={styles.body}>{children}</div>
    </dialog>
  );
}
