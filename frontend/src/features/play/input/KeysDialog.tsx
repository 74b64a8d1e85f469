import { useEffect, useState } from "react";

import { Button } from "@/components/controls/Button";
import { Dialog } from "@/components/controls/Dialog";
import { useSetting } from "@/features/play/settings/stored";

import { addKey, type Control, CONTROLS, DEFAULT_KEYS, keyName, KEYS, withoutKey } from "./keys";
import styles from "./KeysDialog.module.css";

const CONTROL_NAMES: Readonly<Record<Control, string>> = {
  left: "Left",
  right: "Right",
  fire: "Fire",
  rewind: "Rewind",
  pause: "Pause",
};

/** Assigns keys to the controls. */
export function KeysDialog({ onClose }: { onClose: () => void }) {
  const [keys, setKeys] = useSetting(KEYS);
  const [waiting, setWaiting] = useState<Control | null>(null);

  useEffect(() => {
    if (!waiting) return undefined;
    const take = (event: KeyboardEvent) => {
      // Keep it from the dialog and its buttons.
      event.preventDefault();
      event.stopPropagation();
      if (event.code !== "") setKeys(addKey(keys, waiting, event.code));
      setWaiting(null);
    };
    window.addEventListener("keydown", take, { capture: true });
    return () => window.removeEventListener("keydown", take, { capture: true });
  }, [waiting, keys, setKeys]);

  return (
    <Dialog title="Keys" onClose={onClose}>
      <ul className={styles.bindings}>
        {CONTROLS.map((control) => {
          const name = CONTROL_NAMES[control];
          return (
            <li key={control} aria-label={name}>
              <span>{name}</span>
              <span className={styles.codes}>
                {keys[control].map((code) => (
                  <Button
                    key={code}
                    kind="quiet"
                    aria-label={`Remove ${keyName(code)} from ${name}`}
                    title="Remove"
                    onClick={() => setKeys(withoutKey(keys, code))}
                  >
                    <kbd>{keyName(code)}</kbd>
                  </Button>
                ))}
                <Button
                  icon="plus"
                  aria-pressed={waiting === control}
                  onClick={() => setWaiting(control)}
                >
                  {waiting === control ? "Press a key" : "Add a key"}
                </Button>
              </span>
            </li>
          );
        })}
      </ul>
      <p className={styles.tip}>
        Either hand can play alone: the arrows with ↑ to fire, or A and D with W. Left and right
        together cancel out. A gamepad works too: stick or D-pad to move, any face button to fire,
        the shoulder buttons to rewind, Start to begin, pause and play again.
      </p>
      <div>
        <Button onClick={() => setKeys(DEFAULT_KEYS)}>Restore the default keys</Button>
      </div>
    </Dialog>
  );
}
