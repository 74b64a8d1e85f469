import { t } from "@lingui/core/macro";
import type { PointerEvent } from "react";

import { FIRE, LEFT, RIGHT } from "./keys";
import styles from "./TouchPad.module.css";

const buttons = () =>
  [
    { name: t`Left`, sign: "←", bit: LEFT },
    { name: t`Right`, sign: "→", bit: RIGHT },
    { name: t`Fire`, sign: t`Fire`, bit: FIRE },
  ] as const;

/** Touch buttons; several can be held at once. */
export function TouchPad({
  idle,
  onHold,
  onRelease,
}: {
  /** Whether nothing is played: where it lies over the picture, it makes room then. */
  idle: boolean;
  onHold: (name: string, bit: number, atMs: number) => void;
  onRelease: (name: string) => void;
}) {
  return (
    <div
      className={styles.pad}
      role="group"
      aria-label={t`Touch controls`}
      data-idle={idle || undefined}
    >
      {buttons().map(({ name, sign, bit }) => {
        const release = (event: PointerEvent) => onRelease(fingerName(event, name));
        return (
          <button
            key={name}
            type="button"
            aria-label={name}
            onContextMenu={(event) => event.preventDefault()}
            onPointerDown={(event) => {
              event.preventDefault();
              event.currentTarget.setPointerCapture(event.pointerId);
              onHold(fingerName(event, name), bit, event.timeStamp);
            }}
            onPointerUp={release}
            onPointerCancel={release}
            onLostPointerCapture={release}
          >
            {sign}
          </button>
        );
      })}
    </div>
  );
}

function fingerName(event: PointerEvent, name: string): string {
  return `${name}-${event.pointerId}`;
}
