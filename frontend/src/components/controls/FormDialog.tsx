import { Trans } from "@lingui/react/macro";
import type { ReactNode, SubmitEvent } from "react";

import { messageOf } from "@/api/client";
import { Notice } from "@/components/feedback/States";

import { Button } from "./Button";
import { Dialog } from "./Dialog";
import type { Draft } from "./drafts";
import styles from "./FormDialog.module.css";

interface FormDialogProps {
  title: string;
  /** As a CSS length. */
  width?: string;
  /** What was typed, which Cancel forgets and closing keeps. */
  draft: Pick<Draft<unknown>, "drop">;
  /** The label of the button that submits. */
  submit: string;
  disabled?: boolean;
  /** What went wrong, unless a field says so. */
  error?: unknown;
  onSubmit: (form: HTMLFormElement) => void;
  onClose: () => void;
  /** Further buttons, at the end of the row. */
  more?: ReactNode;
  children: ReactNode;
}

/** A dialog with a form, a line for its error, and buttons to submit and to cancel. */
export function FormDialog(props: FormDialogProps) {
  const { title, width, draft, submit, disabled = false, error, onSubmit, onClose } = props;
  return (
    <Dialog title={title} onClose={onClose} width={width}>
      <form
        className={styles.form}
        noValidate
        onSubmit={(event: SubmitEvent<HTMLFormElement>) => {
          event.preventDefault();
          // Text that is not a number has no value, and would be dropped.
          const unreadable = [...event.currentTarget.querySelectorAll("input")].find(
            ({ validity }) => validity.badInput,
          );
          if (unreadable) {
            unreadable.focus();
            return;
          }
          onSubmit(event.currentTarget);
        }}
      >
        {props.children}
        {Boolean(error) && (
          <Notice tone="bad" live>
            <p>{messageOf(error)}</p>
          </Notice>
        )}
        <div className={styles.actions}>
          <Button kind="primary" type="submit" disabled={disabled}>
            {submit}
          </Button>
          <Button
            kind="quiet"
            onClick={() => {
              draft.drop();
              onClose();
            }}
          >
            <Trans>Cancel</Trans>
          </Button>
          {props.more && <div className={styles.more}>{props.more}</div>}
        </div>
      </form>
    </Dialog>
  );
}
