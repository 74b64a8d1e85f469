import type { CSSProperties, ReactNode } from "react";

import { classes } from "@/lib/classes";
import { type Actor, actorNames, ACTOR_SHAPES, actorColour } from "@/lib/actors";

import styles from "./ActorMark.module.css";

interface ActorMarkProps {
  actor: Actor;
  /** Whether only the outline is drawn. */
  hollow?: boolean;
  children?: ReactNode;
}

/** The mark of an actor in its colour, with its name or other text beside it. */
export function ActorMark({ actor, hollow = false, children }: ActorMarkProps) {
  return (
    <span className={styles.mark} style={{ "--actor": actorColour(actor) } as CSSProperties}>
      <svg viewBox="0 0 10 10" width="10" height="10" aria-hidden="true">
        <path d={ACTOR_SHAPES[actor]} className={classes(hollow && styles.hollow)} />
      </svg>
      <span>{children ?? actorNames()[actor]}</span>
    </span>
  );
}
