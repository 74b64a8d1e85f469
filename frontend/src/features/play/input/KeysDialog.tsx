import { t } from "@lingui/core/macro";
import { Trans } from "@lingui/react/macro";
import { useEffect, useState } from "react";

import { Button } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
import { useGame } from "@/games/game";
import { placeOf } from "@/lib/browser/pressed-keys";

import {
  addKey,
  type Control,
  controlName,
  controlsOf,
  defaultKeys,
  isAssignable,
  useKeyMap,
  useKeyNames,
  withoutKey,
} from "./keys";
import styles from "./KeysDialog.module.css";

/** Assigns keys to the controls. */
export function KeysDialog({ onClose }: { onClose: () => void }) {
  const game = useGame();
  const [keys, setKeys] = useKeyMap();
  const [waiting, setWaiting] = useState<Control | null>(null);
  const nameOf = useKeyNames();

  useEffect(() => {
    if (!waiting) return undefined;
    const take = (event: KeyboardEvent) => {
      // Keep it from the dialog and its buttons.
      event.preventDefault();
      event.stopPropagation();
      const code = placeOf(event);
      // Modifiers belong to the browser and the system.
      if (!isAssignable(code)) return;
      setKeys(addKey(keys, waiting, code));
      setWaiting(null);
    };
    window.addEventListener("keydown", take, { capture: true });
    return () => window.removeEventListener("keydown", take, { capture: true });
  }, [waiting, keys, setKeys]);

  return (
    <Dialog title={t`Keys`} onClose={onClose}>
      <ul className={styles.bindings}>
        {controlsOf(game).map((control) => {
          const name = controlName(control);
          return (
            <li key={control} aria-label={name}>
              <span>{name}</span>
              <span className={styles.codes}>
                {(keys[control] ?? []).map((code) => (
                  <Button
                    key={code}
                    kind="quiet"
                    aria-label={t`Remove ${nameOf(code)} from ${name}`}
                    title={t`Remove`}
                    onClick={() => setKeys(withoutKey(keys, code))}
                  >
                    <kbd>{nameOf(code)}</kbd>
                  </Button>
                ))}
                <Button
                  icon="plus"
                  aria-pressed={waiting === control}
                  onClick={() => setWaiting(control)}
                >
                  {waiting === control ? t`Press a key` : t`Add a key`}
                </Button>
              </span>
            </li>
          );
        })}
      </ul>
      <p className={styles.tip}>
        <Trans>
          Every game with these buttons uses them. A gamepad works, too: stick or D-pad to move, a
          face button to fire, a shoulder button to rewind, Start to begin, pause and play again.
        </Trans>
      </p>
      <div>
        <Button onClick={() => setKeys(defaultKeys(game))}>
          <Trans>Restore the default keys</Trans>
        </Button>
      </div>
    </Dialog>
  );
}
