import { t } from "@lingui/core/macro";
import type { PointerEvent } from "react";

import { useGame } from "@/games/game";
import { classes } from "@/lib/classes";

import { DIRECTIONS, directionsAt } from "./directions";
import { buttonBit, controlName } from "./keys";
import styles from "./TouchPad.module.css";

interface TouchPadProps {
  /** Whether nothing is played: where it lies over the picture, it makes room then. */
  idle: boolean;
  onHold: (name: string, bits: number, atMs: number) => void;
  onRelease: (name: string) => void;
}

/** The game's buttons for touch: a pad of eight directions where it has them. Several can be held. */
export function TouchPad({ idle, onHold, onRelease }: TouchPadProps) {
  const { buttons } = useGame();
  const isSteered = buttons.includes("up") || buttons.includes("down");
  const rest = buttons.filter((name) => !isSteered || !DIRECTIONS.some((one) => one === name));
  return (
    <div
      className={classes(styles.pad, layoutOf(buttons, isSteered))}
      role="group"
      aria-label={t`Touch controls`}
      data-idle={idle || undefined}
    >
      {isSteered && <Directions buttons={buttons} onHold={onHold} onRelease={onRelease} />}
      {rest.map((button) => {
        const bit = buttonBit(buttons, button);
        const release = (event: PointerEvent) => onRelease(fingerName(event, button));
        return (
          <button
            key={button}
            type="button"
            className={button === "fire" ? styles.fire : undefined}
            aria-label={controlName(button)}
            onContextMenu={(event) => event.preventDefault()}
            onPointerDown={(event) => {
              event.preventDefault();
              event.currentTarget.setPointerCapture(event.pointerId);
              onHold(fingerName(event, button), bit, event.timeStamp);
            }}
            onPointerUp={release}
            onPointerCancel={release}
            onLostPointerCapture={release}
          >
            {SIGNS[button] ?? controlName(button)}
          </button>
        );
      })}
    </div>
  );
}

const SIGNS: Readonly<Record<string, string>> = { left: "←", right: "→", up: "↑", down: "↓" };

function layoutOf(buttons: readonly string[], isSteered: boolean): string | undefined {
  if (isSteered) return styles.steered;
  const isJoystick = buttons.includes("left") && buttons.includes("right") && buttons.length <= 3;
  return isJoystick ? styles.sideways : styles.named;
}

/** Where the arrows lie, of 100. */
const ARROWS = {
  up: { x: 50, y: 17 },
  down: { x: 50, y: 83 },
  left: { x: 17, y: 50 },
  right: { x: 83, y: 50 },
} as const;

/** A pad on which a thumb slides between the directions of the game, diagonals among them. */
function Directions({
  buttons,
  onHold,
  onRelease,
}: Pick<TouchPadProps, "onHold" | "onRelease"> & { buttons: readonly string[] }) {
  const release = (event: PointerEvent<HTMLElement>) => {
    event.currentTarget.removeAttribute("data-held");
    onRelease(fingerName(event, "directions"));
  };
  const hold = (event: PointerEvent<HTMLElement>) => {
    const box = event.currentTarget.getBoundingClientRect();
    const x = ((event.clientX - box.left) / box.width) * 2 - 1;
    const y = ((event.clientY - box.top) / box.height) * 2 - 1;
    const held = directionsAt(x, y).filter((direction) => buttons.includes(direction));
    event.currentTarget.setAttribute("data-held", held.join(" "));
    const bits = held.reduce((all, direction) => all | buttonBit(buttons, direction), 0);
    onHold(fingerName(event, "directions"), bits, event.timeStamp);
  };
  return (
    <div
      className={styles.directions}
      role="img"
      aria-label={t`Directions: slide your thumb`}
      onContextMenu={(event) => event.preventDefault()}
      onPointerDown={(event) => {
        event.preventDefault();
        event.currentTarget.setPointerCapture(event.pointerId);
        hold(event);
      }}
      onPointerMove={(event) => {
        if (event.currentTarget.hasPointerCapture(event.pointerId)) hold(event);
      }}
      onPointerUp={release}
      onPointerCancel={release}
      onLostPointerCapture={release}
    >
      {DIRECTIONS.filter((direction) => buttons.includes(direction)).map((direction) => (
        <span
          key={direction}
          data-direction={direction}
          style={{ left: `${ARROWS[direction].x}%`, top: `${ARROWS[direction].y}%` }}
        >
          {SIGNS[direction]}
        </span>
      ))}
    </div>
  );
}

function fingerName(event: PointerEvent, name: string): string {
  return `${name}-${event.pointerId}`;
}
