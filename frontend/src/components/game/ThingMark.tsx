import type { CSSProperties, ReactNode } from "react";

import { classes } from "@/lib/classes";
import { type Thing, thingNames, THING_SHAPES, thingColour } from "@/lib/things";

import styles from "./ThingMark.module.css";

interface ThingMarkProps {
  thing: Thing;
  /** Whether only the outline is drawn. */
  hollow?: boolean;
  children?: ReactNode;
}

/** The mark of a thing in its colour, with its name or other text beside it. */
export function ThingMark({ thing, hollow = false, children }: ThingMarkProps) {
  return (
    <span className={styles.mark} style={{ "--thing": thingColour(thing) } as CSSProperties}>
      <svg viewBox="0 0 10 10" width="10" height="10" aria-hidden="true">
        <path d={THING_SHAPES[thing]} className={classes(hollow && styles.hollow)} />
      </svg>
      <span>{children ?? thingNames()[thing]}</span>
    </span>
  );
}
