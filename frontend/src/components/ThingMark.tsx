import type { CSSProperties, ReactNode } from "react";

import styles from "./ThingMark.module.css";

import { type Thing, THING_NAMES, thingColour } from "@/lib/things";

const SHAPES: Readonly<Record<Thing, string>> = {
  imitator: "M5 1a4 4 0 1 0 0 8 4 4 0 0 0 0-8",
  clone: "M5 .4 9.6 5 5 9.6.4 5z",
  person: "M5 .8 9.4 9H.6z",
  demonstrator: "M1.4 1.4h7.2v7.2H1.4z",
};

/** A thing's mark in its colour, with its name or other words beside it. */
export function ThingMark({ thing, children }: { thing: Thing; children?: ReactNode }) {
  return (
    <span className={styles.mark} style={{ "--thing": thingColour(thing) } as CSSProperties}>
      <svg viewBox="0 0 10 10" width="10" height="10" aria-hidden="true">
        <path d={SHAPES[thing]} />
      </svg>
      <span>{children ?? THING_NAMES[thing]}</span>
    </span>
  );
}
