import { type CSSProperties, type ReactNode, useEffect, useId, useRef } from "react";

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

/**
 * A modal dialog, open while it is rendered. Escape, the close button and a click on the backdrop
 * call `onClose`. The browser traps the focus and restores it.
 */
export function Dialog({ title, onClose, width, children }: DialogProps) {
  const ref = useRef<HTMLDialogElement>(null);
  const titleId = useId();

  useEffect(() => {
    const dialog = ref.current;
    if (!dialog) return undefined;
    if (!dialog.open) dialog.showModal();
    return () => dialog.close();
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
        {onClose && <IconButton icon="close" label="Close" onClick={onClose} />}
      </div>
      <div className={styles.body}>{children}</div>
    </dialog>
  );
}
