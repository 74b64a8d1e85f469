import { t } from "@lingui/core/macro";
import {
  createContext,
  type ReactNode,
  useCallback,
  useContext,
  useEffect,
  useMemo,
  useRef,
  useState,
} from "react";

import { Button, IconButton } from "@/components/controls/Button";

import styles from "./Toasts.module.css";

interface Toast {
  readonly id: number;
  readonly message: string;
  readonly action?: { readonly label: string; readonly run: () => void };
}

type Show = (message: string, action?: Toast["action"]) => void;

const ToastContext = createContext<Show | null>(null);

const SHOWN_MS = 6000;
/** Longer, to leave time to undo. */
const SHOWN_WITH_ACTION_MS = 12_000;
const MOST = 3;

/** Provides `useToast` and shows toasts at the bottom of the page, announced to screen readers. */
export function ToastProvider({ children }: { children: ReactNode }) {
  const [toasts, setToasts] = useState<readonly Toast[]>([]);
  const nextId = useRef(1);

  const close = useCallback((id: number) => {
    setToasts((shown) => shown.filter((toast) => toast.id !== id));
  }, []);

  const show = useCallback<Show>((message, action) => {
    const id = nextId.current;
    nextId.current += 1;
    const toast = action ? { id, message, action } : { id, message };
    setToasts((shown) => [...shown.slice(1 - MOST), toast]);
  }, []);

  return (
    <ToastContext value={show}>
      {children}
      <div className={styles.region} role="status" aria-live="polite" aria-label={t`Messages`}>
        {toasts.map((toast) => (
          <ToastView key={toast.id} toast={toast} onClose={close} />
        ))}
      </div>
    </ToastContext>
  );
}

function ToastView({ toast, onClose }: { toast: Toast; onClose: (id: number) => void }) {
  const [held, setHeld] = useState(false);
  useEffect(() => {
    if (held) return undefined;
    const shown = toast.action ? SHOWN_WITH_ACTION_MS : SHOWN_MS;
    const timer = setTimeout(() => onClose(toast.id), shown);
    return () => clearTimeout(timer);
  }, [held, onClose, toast]);

  const hold = useMemo(
    () => ({
      onMouseEnter: () => setHeld(true),
      onMouseLeave: () => setHeld(false),
      onFocus: () => setHeld(true),
      onBlur: () => setHeld(false),
    }),
    [],
  );
  const { action } = toast;
  return (
    <div className={styles.toast} {...hold}>
      <span>{toast.message}</span>
      <span className={styles.actions}>
        {action && (
          <Button
            kind="quiet"
            className={styles.action}
            onClick={() => {
              onClose(toast.id);
              action.run();
            }}
          >
            {action.label}
          </Button>
        )}
        <IconButton icon="close" label={t`Close message`} onClick={() => onClose(toast.id)} />
      </span>
    </div>
  );
}

/** Returns a function that shows a message, optionally with an action button. */
export function useToast(): Show {
  const show = useContext(ToastContext);
  if (!show) throw new Error("useToast needs a ToastProvider above it.");
  return show;
}
