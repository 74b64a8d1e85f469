/** The four who play, each with its own colour and mark on every page. */

export const THINGS = ["imitator", "clone", "person", "demonstrator"] as const;
export type Thing = (typeof THINGS)[number];

export const THING_NAMES: Readonly<Record<Thing, string>> = {
  imitator: "Imitator",
  clone: "Clone",
  person: "Person",
  demonstrator: "Demonstrator",
};

/** A thing's mark, in a box of 10 by 10. */
export const THING_SHAPES: Readonly<Record<Thing, string>> = {
  imitator: "M5 1a4 4 0 1 0 0 8 4 4 0 0 0 0-8",
  clone: "M5 .4 9.6 5 5 9.6.4 5z",
  person: "M5 .8 9.4 9H.6z",
  demonstrator: "M1.4 1.4h7.2v7.2H1.4z",
};

/** CSS variable of a thing's colour. */
export function thingColour(thing: Thing): string {
  return `var(--${thing})`;
}

/** Who played a recording, by its source. Which policy it was is known by the run alone. */
export function playedBy(source: "person" | "scripted" | "policy"): Thing {
  if (source === "person") return "person";
  return source === "scripted" ? "demonstrator" : "imitator";
}
